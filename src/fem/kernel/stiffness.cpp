// The force kernel. Per element in space: 72 additions to patterns, 72 multiplications and 48
// additions in the blocks, 72 additions back, 48 for the assembly. Four times as fast as the dense
// matrix.
//
// Rejected: scatter by element with gathered indices (no unit stride), colouring of elements
// (another order of sums per rank), fused multiply-add (results would depend on the choices of the
// compiler).
#include "fem/kernel/stiffness.hpp"

#include <algorithm>
#include <cmath>

#include "fem/shape/lanes.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

// Corner forces of a run, separate for the left and right corners of its elements. Size for a run
// of 64 elements and a whole vector beyond it.
template <int D>
struct RunForces {
  static constexpr int lines = 1 << (D - 1);
  double left[D][lines][64 + 8], right[D][lines][64 + 8];
};

// Corner forces of elements at, at + 1 ... at + 7 of a run. Lanes beyond the end of the run compute
// values from the nodes that follow (or padding), which are never added. factor: of each element of
// the run; only if they differ.
template <int D, bool differ>
inline void eight_elements(const Stiffness::Blocks& stiffness, const double* const (&from)[D][4],
                           const double* factor, std::int32_t at, RunForces<D>& forces) {
  constexpr int corners = 1 << D;
  // All indices below are compile-time constants: unrolled, all values are in registers.
  Lane u[D][corners], f[D][corners];
#pragma GCC unroll 8
  for (int c = 0; c < D; ++c) {
#pragma GCC unroll 8
    for (int k = 0; k < corners; ++k) u[c][k] = load(from[c][k >> 1] + at + (k & 1));
    to_patterns<D>(u[c]);
  }
#pragma GCC unroll 8
  for (int g = 0; g < corners; ++g)
#pragma GCC unroll 8
    for (int c = 0; c < D; ++c) {
      // The order of terms is fixed, so that results are bitwise identical.
      Lane sum = stiffness.block[g][c][0] * u[0][g ^ 1];
#pragma GCC unroll 8
      for (int d = 1; d < D; ++d) sum += stiffness.block[g][c][d] * u[d][g ^ (1 << d)];
      if constexpr (differ) sum *= load(factor + at);
      f[c][g ^ (1 << c)] = sum;
    }
#pragma GCC unroll 8
  for (int c = 0; c < D; ++c) {
    to_corners<D>(f[c]);
#pragma GCC unroll 8
    for (int l = 0; l < corners / 2; ++l) {
      store(&forces.left[c][l][at], f[c][2 * l]);
      store(&forces.right[c][l][at], f[c][2 * l + 1]);
    }
  }
}

// A node receives first the force of the element on its left, then that of the element on its
// right: ascending elements.
inline void add_line(double* to, const double* left, const double* right, std::int32_t elements) {
  to[0] += left[0];
  for (std::int32_t n = 1; n < elements; ++n) to[n] = (to[n] + right[n - 1]) + left[n];
  to[elements] += right[elements - 1];
}

// Runs are in the order of element numbers, so each node receives the forces of its elements in
// ascending order, however the runs are cut.
template <int D, class Runs>
void apply_runs(const Runs& runs, const std::vector<Stiffness::Blocks>& blocks,
                const std::vector<double>& factor, const Nodal& w, Nodal& f) {
  constexpr int lines = 1 << (D - 1);
  RunForces<D> forces;
  for (const auto& run : runs) {
    const double* from[D][4];
    for (int c = 0; c < D; ++c)
      for (int l = 0; l < lines; ++l) from[c][l] = w[c] + run.line[static_cast<std::size_t>(l)];
    const auto& stiffness = blocks[static_cast<std::size_t>(run.solid)];
    if (run.factors < 0)
      for (std::int32_t at = 0; at < run.elements; at += lanes)
        eight_elements<D, false>(stiffness, from, nullptr, at, forces);
    else
      for (std::int32_t at = 0; at < run.elements; at += lanes)
        eight_elements<D, true>(stiffness, from, factor.data() + run.factors, at, forces);
    for (int l = 0; l < lines; ++l)
      for (int c = 0; c < D; ++c)
        add_line(f[c] + run.line[static_cast<std::size_t>(l)], forces.left[c][l],
                 forces.right[c][l], run.elements);
  }
}

// With u_k = 1/n sum_p s_pk m_p and f_k = sum_p s_pk t_p: t = (1/n^2) S K S^T m.
Stiffness::Blocks blocks_of(const Eigen::MatrixXd& k, int components) {
  const int corners = 1 << components;
  const Eigen::MatrixXd patterns = patterns_of(corners, components);
  Eigen::MatrixXd t = patterns * k * patterns.transpose() / (corners * corners);
  // Entries that are zero by symmetry are rounding errors here; exact zeros make rigid translations
  // free of force.
  const double noise = 1e-13 * t.cwiseAbs().maxCoeff();
  t = (t.array().abs() < noise).select(0.0, t);
  Stiffness::Blocks blocks{};
  double inside = 0;  // squared norm of the blocks; must equal that of the matrix
  for (int g = 0; g < corners; ++g)
    for (int c = 0; c < components; ++c)
      for (int d = 0; d < components; ++d) {
        const double value = t((g ^ (1 << c)) * components + c, (g ^ (1 << d)) * components + d);
        blocks.block[g][c][d] = value;
        inside += value * value;
      }
  require(std::abs(inside - t.squaredNorm()) < 1e-10 * inside,
          "the stiffness of an element has the symmetry of a box");
  return blocks;
}

}  // namespace

Stiffness::Stiffness(const Mesh& mesh, std::vector<ElementMatrices> matrices, double common_damping)
    : matrices_(std::move(matrices)),
      images_(mesh.images),
      nodes_(mesh.nodes()),
      components_(mesh.lattice.components()) {
  if (mesh.imported) {
    tetrahedra_.emplace(mesh, common_damping);
    damps_ = tetrahedra_->damps();
    return;
  }
  for (const ElementMatrices& matrices : matrices_)
    blocks_.push_back(blocks_of(matrices.stiffness, components_));
  cut_into_runs(mesh);
  for (std::size_t s = 0; s < blocks_.size(); ++s) {
    const double more = mesh.solids.solid[s].rayleigh_stiffness - common_damping;
    damps_ = damps_ || more != 0;
    damping_.push_back(blocks_[s]);
    for (auto& block : damping_[s].block)
      for (auto& row : block)
        for (double& value : row) value *= more;
    for (const Run& run : runs_)
      if (more != 0 && static_cast<std::size_t>(run.solid) == s) damped_runs_.push_back(run);
  }
}

// Elements are ascending with x fastest, so a row of the lattice is contiguous unless the partition
// or a change of solid cuts it. Factors do not depend on where a run begins: results are bitwise
// identical on any number of ranks.
void Stiffness::cut_into_runs(const Mesh& mesh) {
  const auto alike = [&](std::size_t element) {
    return mesh.solids.alike[static_cast<std::size_t>(mesh.solid[element])];
  };
  for (std::size_t z = 0; z < mesh.element.size(); ++z) {
    const bool row_begins = mesh.lattice.element_index(mesh.element[z])[0] == 0;
    const bool goes_on = z > 0 && !row_begins && mesh.element[z] == mesh.element[z - 1] + 1 &&
                         alike(z) == alike(z - 1) && runs_.back().elements < longest_run;
    if (goes_on)
      ++runs_.back().elements;
    else
      runs_.push_back({1, alike(z), mesh.line[z], -1});
  }
  runs_.shrink_to_fit();
  for (std::size_t z = 0; Run & run : runs_) {
    const auto young = [&](std::int32_t solid) {
      return mesh.solids.solid[static_cast<std::size_t>(solid)].young;
    };
    const auto begin = static_cast<std::int32_t>(factor_.size());
    for (std::int32_t n = 0; n < run.elements; ++n)
      factor_.push_back(young(mesh.solid[z++]) / young(run.solid));
    if (std::all_of(factor_.begin() + begin, factor_.end(), [](double f) { return f == 1; }))
      factor_.resize(static_cast<std::size_t>(begin));
    else
      run.factors = begin;
  }
  if (!factor_.empty()) factor_.resize(factor_.size() + lanes, 0.0);
  factor_.shrink_to_fit();
}

// Solid by solid, within each in the order of elements: the same order of sums on any number of
// ranks.
void Stiffness::add_damping(const Nodal& v, Nodal& f) const {
  if (tetrahedra_) return tetrahedra_->add_damping(v, f);
  if (components_ == 2)
    apply_runs<2>(damped_runs_, damping_, factor_, v, f);
  else
    apply_runs<3>(damped_runs_, damping_, factor_, v, f);
  fold(images_, f);
}

// Forces of ghosts are sums over the held elements only, and not complete.
void Stiffness::apply(const Nodal& w, Nodal& f) const {
  for (int c = 0; c < components_; ++c) std::fill_n(f[c], nodes_, 0.0);
  if (tetrahedra_) return tetrahedra_->add_force(w, f);
  if (components_ == 2)
    apply_runs<2>(runs_, blocks_, factor_, w, f);
  else
    apply_runs<3>(runs_, blocks_, factor_, w, f);
  fold(images_, f);
}

}  // namespace trackbed::fem
