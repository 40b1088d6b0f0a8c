// Numerical output of the ground: sensors of the top face, stresses, totals.
//
// Stresses are those of the deviation, since settling; the fields contain the static stress beside
// them, so that a reader can add both. Nothing here changes the state.
#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/ground/impl.hpp"
#include "fem/shape/tetrahedron.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/fine_sum.hpp"

namespace trackbed::fem {

namespace {

// Elastic stress at the point of `recovery`, from the corner displacements.
Vec6 stress_of(const Mesh& mesh, std::size_t element, const Eigen::MatrixXd& recovery,
               const Nodal& u) {
  const int components = mesh.lattice.components();
  Vec6 stress = Vec6::Zero();
  for (int k = 0; k < mesh.lattice.corners(); ++k)
    for (int c = 0; c < components; ++c)
      stress += recovery.col(k * components + c) * u[c][mesh.corner(element, k)];
  return stress;
}

// Sum of the terms of all ranks: bitwise identical for any distribution of the terms.
double sum_of(const par::Comm& comm, const std::vector<double>& terms) {
  double most = 0;
  bool finite = true;
  for (const double term : terms)
    most = std::max(most, std::abs(term)), finite = finite && std::isfinite(term);
  if (comm.max(std::int64_t{!finite}) != 0) return std::numeric_limits<double>::quiet_NaN();
  const auto count = static_cast<double>(comm.sum(static_cast<std::int64_t>(terms.size())));
  const double largest = comm.max(most) * count;
  if (!(largest > 0)) return 0;
  FineSum sum(largest);
  for (const double term : terms) sum.add(term);
  comm.sum(std::span<std::int64_t>(sum.counts()));
  sum.carry();
  return sum.value();
}

}  // namespace

// xx yy zz xy yz zx.
Vec6 Ground::Impl::stress(std::size_t element, Plasticity::Where where,
                          Plasticity::When when) const {
  const Nodal& u =
      when == Plasticity::When::static_ ? state.static_displacement : state.displacement;
  if (mesh.imported) {
    Vec6 at_centre = stiffness.tetrahedra().stress(element, tetrahedron_centre(), u);
    if (plasticity) at_centre += plasticity->stress(element, where, when);
    return at_centre;
  }
  const ElementMatrices& matrices = stiffness.matrices(mesh.solid[element]);
  const bool top = where == Plasticity::Where::top;
  Vec6 found = stress_of(mesh, element, top ? matrices.top_stress : matrices.centre_stress, u);
  if (plasticity) found += plasticity->stress(element, where, when);
  return found;
}

// Mean over the elements below the node, each at the middle of its top face, where the recovered
// stress is most accurate. Pa, sigma_z, tension positive. The owner holds all these elements.
double Ground::Impl::surface_stress(std::int32_t node) const {
  if (mesh.imported) return imported_surface_stress(node);
  std::array<Id, 8> elements{};
  const int count = mesh.lattice.elements_at(mesh.node[static_cast<std::size_t>(node)], elements);
  double sum = 0;
  for (int z = 0; z < count; ++z) {
    const auto element =
        static_cast<std::size_t>(mesh.local_element(elements[static_cast<std::size_t>(z)]));
    sum += stress(element, Plasticity::Where::top, Plasticity::When::since)(2);
  }
  return sum / count;
}

// The same over the faces around the node.
double Ground::Impl::imported_surface_stress(std::int32_t node) const {
  double sum = 0;
  int count = 0;
  auto at = std::lower_bound(faces_at.begin(), faces_at.end(), std::pair(node, 0));
  for (; at != faces_at.end() && at->first == node; ++at, ++count) {
    const Imported::Face& face = mesh.imported->top[static_cast<std::size_t>(at->second)];
    const auto element = static_cast<std::size_t>(face.element);
    const Vec3 xi = tetrahedron_face_centre(face.side);
    sum += stiffness.tetrahedra().stress(element, xi, state.displacement)(2);
    if (plasticity) sum += plasticity->stress_at(element, xi, Plasticity::When::since)(2);
  }
  return sum / count;
}

// Ascending, as nodes of the surface are numbered.
std::vector<std::int32_t> Ground::own_top() const {
  std::vector<std::int32_t> numbers;
  for (const TopNode& top : impl_->own_top) numbers.push_back(top.number);
  return numbers;
}

// The mesh node of an own node of the surface. Both faces of a plane model share the plane node.
std::int32_t Ground::Impl::node_of_top(std::int32_t number) const {
  const auto found =
      std::lower_bound(own_top.begin(), own_top.end(), number,
                       [](const TopNode& t, std::int32_t n) { return t.number < n; });
  require(found != own_top.end() && found->number == number,
          "a rank writes only top nodes that it owns");
  return found->node;
}

Ground::TopState Ground::top_state(std::int32_t number) const {
  const std::int32_t node = impl_->node_of_top(number);
  const State& state = impl_->state;
  return {impl_->at_top(state.displacement, node), impl_->at_top(state.velocity, node),
          impl_->at_top(state.acceleration, node), impl_->surface_stress(node)};
}

Ground::TopMotion Ground::top_motion(std::int32_t number) const {
  const std::int32_t node = impl_->node_of_top(number);
  const State& state = impl_->state;
  return {impl_->at_top(state.displacement, node), impl_->at_top(state.velocity, node),
          impl_->at_top(state.acceleration, node)};
}

double Ground::top_mass(std::int32_t number) const {
  const std::int32_t node = impl_->node_of_top(number);
  if (impl_->flat_top) return impl_->flat_top->mass(node);
  const auto at = static_cast<std::size_t>(node);
  return impl_->terms.mass[at] / impl_->mesh.lattice.shown(impl_->mesh.node[at]);
}

// Of the motion since static equilibrium: 1/2 v M v and 1/2 u K u with the springs. Over own nodes:
// each counts once.
GroundEnergies Ground::Impl::energies() const {
  GroundEnergies total;
  Nodal force(components(), mesh.nodes());
  stiffness.apply(state.displacement, force);
  for (const Spring& s : terms.springs)
    for (int c = 0; c < components(); ++c)
      force[c][s.node] += s.stiffness * state.displacement[c][s.node];
  std::vector<double> kinetic, elastic;
  for (const std::int32_t n : mesh.own)
    for (int c = 0; c < components(); ++c) {
      const double v = state.velocity[c][n];
      kinetic.push_back(0.5 * terms.mass[static_cast<std::size_t>(n)] * v * v);
      elastic.push_back(0.5 * state.displacement[c][n] * force[c][n]);
    }
  if (plasticity) {
    for (const double stored : plasticity->stored(state.static_displacement, state.displacement))
      elastic.push_back(stored);
    total.plastic = sum_of(mesh.comm, plasticity->dissipated());
    total.yields = true;
  }
  total.kinetic = sum_of(mesh.comm, kinetic);
  total.elastic = sum_of(mesh.comm, elastic);
  return total;
}

GroundEnergies Ground::energies() const { return impl_->energies(); }

GroundTotals Ground::totals() const {
  const Impl& impl = *impl_;
  const Mesh& mesh = impl.mesh;
  GroundTotals totals{impl.energies()};
  totals.elements = mesh.element_count();
  totals.nodes = mesh.node_count();
  totals.steps = impl.steps;
  totals.seconds = impl.seconds;
  if (impl.solves > 0)
    totals.iterations_mean =
        static_cast<double>(impl.iterations) / static_cast<double>(impl.solves);
  if (impl.newton_steps > 0)
    totals.newton_mean =
        static_cast<double>(impl.newton_iterations) / static_cast<double>(impl.newton_steps);
  totals.newton_most = static_cast<double>(impl.most_newton_iterations);
  totals.lagging_steps = impl.lagging_steps;
  totals.newton_residuals = impl.newton_residuals;
  totals.springs = mesh.comm.max(impl.terms.springs.empty() ? 0.0 : 1.0) > 0;
  std::int64_t unknowns = 0;
  for (const std::int32_t n : mesh.own)
    for (int c = 0; c < impl.components(); ++c)
      unknowns += (impl.terms.held[static_cast<std::size_t>(n)] >> c & 1) == 0 ? 1 : 0;
  totals.unknowns = mesh.comm.sum(unknowns);
  return totals;
}

void Ground::time_with(Timers& timers) { impl_->timers = &timers; }

// Bytes on this rank; PETSc matrices are not included.
std::size_t Ground::memory() const {
  const Impl& impl = *impl_;
  const std::size_t per_nodal = impl.state.displacement.bytes();
  // The state and the derived arrays of the scheme: explicit four, implicit five (without
  // Newton's).
  const std::size_t nodals = impl.parameters.integrator == Integrator::explicit_ ? 8 + 4 : 10 + 5;
  const std::size_t plastic = impl.plasticity ? impl.plasticity->bytes() : 0;
  return impl.mesh.bytes() + impl.terms.bytes() + impl.stiffness.bytes() + nodals * per_nodal +
         plastic + (impl.flat_top ? impl.flat_top->bytes() : 0);
}

}  // namespace trackbed::fem
