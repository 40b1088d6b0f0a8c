// Masses, border terms and the critical step.
//
// All borders are lumped to nodes, face by face, so that the explicit step remains diagonal: a
// consistent dashpot matrix would need a solve and is not more accurate for waves that the mesh
// resolves.
#include "fem/boundary/terms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "trackbed/core/decompositions.hpp"
namespace trackbed::fem {

namespace {

// Visits the borders of one element after the other, in ascending order: nodal sums are bitwise
// identical on any number of ranks.
struct Builder {
  const Mesh& mesh;
  const GroundParameters& parameters;
  Terms& terms;
  Border border = Border(mesh, parameters);

  // Lysmer's dashpots on one corner of a border face, for all components.
  void dashpots(std::size_t z, std::int32_t node, int normal) const {
    for (int c = 0; c < mesh.lattice.components(); ++c)
      terms.damping[c][node] += border.dashpot(mesh.solid[z], normal, c);
  }

  // Cases: held; viscous with dashpots only; viscous with springs. In static equilibrium a base
  // without springs is held.
  void base(std::size_t z, std::int32_t node) const {
    const auto n = static_cast<std::size_t>(node);
    const auto all = static_cast<std::uint8_t>((1 << mesh.lattice.components()) - 1);
    const bool viscous = parameters.base == Base::viscous;
    const int up = mesh.lattice.components() - 1;
    if (!viscous) terms.held[n] |= all;
    const double spring = border.spring(mesh.solid[z]);
    if (!viscous || spring == 0) terms.held_static[n] |= all;
    if (!viscous) return;
    dashpots(z, node, up);
    if (spring > 0) terms.springs.push_back({node, spring});
  }

  // Viscous and free-field sides give no static support across them; in static equilibrium they act
  // as rollers. Where two sides adjoin, a component held by one of them is held; dashpots of both
  // are summed.
  void side(std::size_t z, std::int32_t node, int normal, bool high) const {
    const Sides kind = parameters.side(normal, high);
    if (kind == Sides::free || kind == Sides::periodic) return;
    const auto n = static_cast<std::size_t>(node);
    const int all = (1 << mesh.lattice.components()) - 1;
    const auto bits = static_cast<std::uint8_t>(kind == Sides::fixed ? all : 1 << normal);
    terms.held_static[n] |= bits;
    if (kind == Sides::roller || kind == Sides::fixed)
      terms.held[n] |= bits;
    else
      dashpots(z, node, normal);
  }

  void borders(std::size_t z) const {
    // A corner of the block is on several borders; each adds its part.
    const Lattice& lattice = mesh.lattice;
    const Index3 at = lattice.element_index(mesh.element[z]);
    const int up = lattice.components() - 1;
    for (int k = 0; k < lattice.corners(); ++k) {
      for (int c = 0; c < up; ++c)
        if (border.on_side(at, k, c)) side(z, mesh.home(mesh.corner(z, k)), c, (k >> c & 1) != 0);
      if (border.on_base(at, k)) base(z, mesh.home(mesh.corner(z, k)));
    }
  }
};

}  // namespace

// rho c_p for motion along the normal, rho c_s across it. In plane stress waves propagate with the
// plate modulus E / (1 - nu^2).
//   rho c_p = sqrt(rho M),  rho c_s = sqrt(rho G),  G = E/(2 (1 + nu)),
//   M = E (1 - nu)/((1 + nu)(1 - 2 nu)), in plane stress E/(1 - nu^2).
// Exact for waves along the normal; waves at an angle are partly reflected.
Impedance impedance(const Elastic& s, bool plane_stress) {
  const double nu = s.poisson, shear = lame_of(s).shear;
  const double modulus =
      plane_stress ? s.young / (1 - nu * nu) : s.young * (1 - nu) / ((1 + nu) * (1 - 2 * nu));
  return {std::sqrt(modulus * s.density), std::sqrt(shear * s.density)};
}

void merge(std::vector<Spring>& springs) {
  std::stable_sort(springs.begin(), springs.end(),
                   [](const Spring& a, const Spring& b) { return a.node < b.node; });
  std::vector<Spring> merged;
  for (const Spring& s : springs)
    if (!merged.empty() && merged.back().node == s.node)
      merged.back().stiffness += s.stiffness;
    else
      merged.push_back(s);
  springs = std::move(merged);
}

// Pa/m. A layer of depth H below the base, fixed at its bottom, would resist a shear with G/H; H is
// assumed to be the depth of the ground. None below a wave: for one of 1 Hz below 20 m of soil they
// would increase the motion of the top by 24 %, whether their deformation is relative to the
// incident wave or to static equilibrium, as the wave reflected by the top moves the base too.
double base_spring(const GroundParameters& parameters, const Elastic& solid, double depth) {
  if (!parameters.base_motion.empty()) return 0;
  return parameters.base_stiffness < 0 ? lame_of(solid).shear / depth : parameters.base_stiffness;
}

bool Border::on_side(const Index3& element, int corner, int normal) const {
  const auto axis = static_cast<std::size_t>(lattice_.axis(normal));
  return element[axis] == ((corner >> normal & 1) != 0 ? lattice_.elements[axis] - 1 : 0);
}

bool Border::on_base(const Index3& element, int corner) const {
  return element[2] == 0 && (corner >> (lattice_.components() - 1) & 1) == 0;
}

// Faces are rectangles: each corner has an equal part.
double Border::face(std::int32_t solid, int normal) const {
  const Vec3& size = solids_.size[static_cast<std::size_t>(solid)];
  return size.prod() / size[lattice_.axis(normal)] / (lattice_.corners() / 2);
}

double Border::dashpot(std::int32_t solid, int normal, int along) const {
  const bool stress = lattice_.plane && parameters_.plane == PlaneState::stress;
  const Impedance of = impedance(solids_.solid[static_cast<std::size_t>(solid)], stress);
  return (along == normal ? of.normal : of.tangential) * face(solid, normal);
}

double Border::spring(std::int32_t solid) const {
  return base_spring(parameters_, solids_.solid[static_cast<std::size_t>(solid)],
                     lattice_.depth()) *
         face(solid, lattice_.components() - 1);
}

Terms::Terms(const Mesh& mesh, const GroundParameters& parameters, const Stiffness& stiffness)
    : mass(mesh.nodes(), 0.0),
      damping(mesh.lattice.components(), mesh.nodes()),
      held(mesh.nodes(), 0),
      held_static(mesh.nodes(), 0) {
  if (mesh.imported) {
    add_tetrahedra(mesh, parameters);
    return;
  }
  // Masses are summed first by elements, then the terms that depend on them.
  const Builder builder{mesh, parameters, *this};
  // Mass damping that differs from that of the ground is added element by element.
  for (std::size_t z = 0; z < mesh.element.size(); ++z) {
    const double part = stiffness.matrices(mesh.solid[z]).corner_mass;
    const double more = mesh.solids.solid[static_cast<std::size_t>(mesh.solid[z])].rayleigh_mass -
                        parameters.rayleigh_mass;
    for (int k = 0; k < mesh.lattice.corners(); ++k) {
      const std::int32_t node = mesh.home(mesh.corner(z, k));
      mass[static_cast<std::size_t>(node)] += part;
      for (int c = 0; c < mesh.lattice.components(); ++c) damping[c][node] += more * part;
    }
    builder.borders(z);
  }
  for (int c = 0; c < mesh.lattice.components(); ++c)
    for (std::size_t n = 0; n < mesh.nodes(); ++n)
      damping[c][n] += parameters.rayleigh_mass * mass[n];
  merge(springs);
}

// Collective; the same step on all ranks.
double critical_step(const Mesh& mesh, const GroundParameters& parameters,
                     const Stiffness& stiffness, std::string& limit) {
  if (mesh.imported) return critical_step_of_tetrahedra(mesh, parameters, stiffness, limit);
  const Lattice& lattice = mesh.lattice;
  const Border border(mesh, parameters);
  const bool springs = parameters.base == Base::viscous && parameters.base_stiffness != 0 &&
                       parameters.base_motion.empty();
  double shortest = std::numeric_limits<double>::infinity();  // s
  // Every rank checks all solids that occur on any rank: a few small eigenvalue problems.
  const std::size_t solids = mesh.solids.solid.size();
  std::vector<std::int64_t> used(2 * solids, 0);  // inside, at the base
  for (std::size_t z = 0; z < mesh.element.size(); ++z) {
    const bool low = springs && lattice.element_index(mesh.element[z])[2] == 0;
    used[2 * static_cast<std::size_t>(mesh.solid[z]) + (low ? 1 : 0)] = 1;
  }
  mesh.comm.sum(used);
  for (std::size_t at = 0; at < used.size(); ++at) {
    if (used[at] == 0) continue;
    const ElementMatrices& matrices = stiffness.matrices(static_cast<std::int32_t>(at / 2));
    Eigen::MatrixXd k = matrices.stiffness;
    const double spring = border.spring(static_cast<std::int32_t>(at / 2));
    for (int f = 0; at % 2 == 1 && f < k.rows() / 2; ++f)  // lower corners come first
      k(f, f) += spring;
    const double squared = symmetric_eigenvalues(k).maxCoeff() / matrices.corner_mass;
    //   h = 2/w (sqrt(1 + z^2) - z),  z = beta w/2,  w^2 = largest eigenvalue of K over the corner
    //   mass. The bound holds element by element (h^2 K / 4 + h C / 2 <= M), each with its own
    //   damping.
    const double omega = std::sqrt(squared);
    const double z = 0.5 * mesh.solids.solid[at / 2].rayleigh_stiffness * omega;
    const double step = 2 / omega * (std::sqrt(1 + z * z) - z);
    if (step >= shortest) continue;
    shortest = step;
    const Vec3& size = mesh.solids.size[at / 2];
    limit = fmt::format("elements of {}{} ({:.4g} x {:.4g} x {:.4g} m)", mesh.solids.name[at / 2],
                        at % 2 == 1 ? " on base springs" : "", size.x(), size.y(), size.z());
    if (z > 0.1) limit += "; this step includes the reduction by rayleigh_stiffness";
  }
  return shortest;
}

}  // namespace trackbed::fem
