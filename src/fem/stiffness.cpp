// The force kernel. Per zone in space: 72 additions to patterns, 72 multiplications and 48
// additions in the blocks, 72 additions back, 48 to assemble. Four times the speed of the dense
// matrix.
//
// Rejected: scatter by zone with gathered indices (no unit stride), colouring of zones (another
// order of sums per rank), fused multiply-add (bits would hang on the compiler's choices).
#include "stiffness.hpp"

#include <algorithm>
#include <cmath>

#include "lanes.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

// Corner forces of a run, kept apart for the left and right corners of its zones.
// Space for a run of 64 zones and the lanes of a vector beyond it.
template <int D>
struct RunForces {
  static constexpr int lines = 1 << (D - 1);
  double left[D][lines][64 + 8], right[D][lines][64 + 8];
};

// Corner forces of zones at, at + 1 ... at + 7 of a run. Lanes beyond the end of the run compute
// something from nodes that follow (or padding); their results are never added.
// factor: of each zone of the run; only if they differ.
template <int D, bool differ>
inline void eight_zones(const Stiffness::Blocks& stiffness, const double* const (&from)[D][4],
                        const double* factor, std::int32_t at, RunForces<D>& forces) {
  constexpr int corners = 1 << D;
  // All indices below are known to the compiler: unrolled, everything lives in registers.
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
      // Fixed order of terms: part of the promise of equal bits.
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

// A node gets first what the zone on its left gives, then the zone on its right: ascending zones.
inline void add_line(double* to, const double* left, const double* right, std::int32_t zones) {
  to[0] += left[0];
  for (std::int32_t n = 1; n < zones; ++n) to[n] = (to[n] + right[n - 1]) + left[n];
  to[zones] += right[zones - 1];
}

// Runs come in the order of zone numbers, so each node sees its zones in ascending order however
// the runs are cut.
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
      for (std::int32_t at = 0; at < run.zones; at += lanes)
        eight_zones<D, false>(stiffness, from, nullptr, at, forces);
    else
      for (std::int32_t at = 0; at < run.zones; at += lanes)
        eight_zones<D, true>(stiffness, from, factor.data() + run.factors, at, forces);
    for (int l = 0; l < lines; ++l)
      for (int c = 0; c < D; ++c)
        add_line(f[c] + run.line[static_cast<std::size_t>(l)], forces.left[c][l],
                 forces.right[c][l], run.zones);
  }
}

// With u_k = 1/n sum_p s_pk m_p and f_k = sum_p s_pk t_p: t = (1/n^2) S K S^T m.
Stiffness::Blocks blocks_of(const Eigen::MatrixXd& k, int components) {
  const int corners = 1 << components;
  const Eigen::MatrixXd patterns = patterns_of(corners, components);
  Eigen::MatrixXd t = patterns * k * patterns.transpose() / (corners * corners);
  // What symmetry makes zero is rounding noise here; exact zeros keep a rigid shift free of force.
  const double noise = 1e-13 * t.cwiseAbs().maxCoeff();
  t = (t.array().abs() < noise).select(0.0, t);
  Stiffness::Blocks blocks{};
  double inside = 0;  // squared size of what the blocks hold; must be all of it
  for (int g = 0; g < corners; ++g)
    for (int c = 0; c < components; ++c)
      for (int d = 0; d < components; ++d) {
        const double value = t((g ^ (1 << c)) * components + c, (g ^ (1 << d)) * components + d);
        blocks.block[g][c][d] = value;
        inside += value * value;
      }
  require(std::abs(inside - t.squaredNorm()) < 1e-10 * inside,
          "the stiffness of a zone lacks the symmetry of a box");
  return blocks;
}

}  // namespace

Stiffness::Stiffness(const Mesh& mesh, std::vector<ZoneElement> elements, double common_damping)
    : elements_(std::move(elements)),
      images_(mesh.images),
      nodes_(mesh.nodes()),
      components_(mesh.lattice.components()) {
  if (mesh.imported) {
    tetrahedra_.emplace(mesh, common_damping);
    damps_ = tetrahedra_->damps();
    return;
  }
  for (const ZoneElement& element : elements_)
    blocks_.push_back(blocks_of(element.stiffness, components_));
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

// Zones are ascending with x fastest, so a row of the lattice is contiguous unless the partition or
// a change of solid cuts it. Factors do not depend on where a run begins: the same bits on any
// number of ranks.
void Stiffness::cut_into_runs(const Mesh& mesh) {
  const auto alike = [&](std::size_t zone) {
    return mesh.solids.alike[static_cast<std::size_t>(mesh.solid[zone])];
  };
  for (std::size_t z = 0; z < mesh.zone.size(); ++z) {
    const bool row_begins = mesh.lattice.zone_index(mesh.zone[z])[0] == 0;
    const bool goes_on = z > 0 && !row_begins && mesh.zone[z] == mesh.zone[z - 1] + 1 &&
                         alike(z) == alike(z - 1) && runs_.back().zones < longest_run;
    if (goes_on)
      ++runs_.back().zones;
    else
      runs_.push_back({1, alike(z), mesh.line[z], -1});
  }
  runs_.shrink_to_fit();
  for (std::size_t z = 0; Run & run : runs_) {
    const auto young = [&](std::int32_t solid) {
      return mesh.solids.solid[static_cast<std::size_t>(solid)].young;
    };
    const auto begin = static_cast<std::int32_t>(factor_.size());
    for (std::int32_t n = 0; n < run.zones; ++n)
      factor_.push_back(young(mesh.solid[z++]) / young(run.solid));
    if (std::all_of(factor_.begin() + begin, factor_.end(), [](double f) { return f == 1; }))
      factor_.resize(static_cast<std::size_t>(begin));
    else
      run.factors = begin;
  }
  if (!factor_.empty()) factor_.resize(factor_.size() + lanes, 0.0);
  factor_.shrink_to_fit();
}

// Solid by solid, within each in the order of zones: the same order of sums on any number of ranks.
void Stiffness::add_damping(const Nodal& v, Nodal& f) const {
  if (tetrahedra_) return tetrahedra_->add_damping(v, f);
  if (components_ == 2)
    apply_runs<2>(damped_runs_, damping_, factor_, v, f);
  else
    apply_runs<3>(damped_runs_, damping_, factor_, v, f);
  fold(images_, f);
}

// Forces of ghosts are sums over the zones held here alone, and not complete.
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
