// What leaves the ground as numbers: sensors of the top face, stresses, totals.
//
// Stresses are those of the deviation, since settling; the fields give the stress at rest beside
// them, so that a reader may add both. Nothing here changes the state.
#include <algorithm>
#include <cmath>
#include <limits>

#include "room.hpp"
#include "tetrahedron.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/fine_sum.hpp"

namespace trackbed::fem {

namespace {

// Elastic stress at the point that `recovery` stands for, from the corner displacements.
Vec6 stress_of(const Mesh& mesh, std::size_t zone, const Eigen::MatrixXd& recovery,
               const Nodal& u) {
  const int components = mesh.lattice.components();
  Vec6 stress = Vec6::Zero();
  for (int k = 0; k < mesh.lattice.corners(); ++k)
    for (int c = 0; c < components; ++c)
      stress += recovery.col(k * components + c) * u[c][mesh.corner(zone, k)];
  return stress;
}

// Of the terms of all ranks: the same bits however they are shared out.
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
Vec6 Ground::Room::stress(std::size_t zone, Plasticity::Where where, Plasticity::When when) const {
  const Nodal& u = when == Plasticity::When::rest ? state.rest : state.displacement;
  if (mesh.imported) {
    Vec6 at_centre = stiffness.tetrahedra().stress(zone, tetrahedron_centre(), u);
    if (plasticity) at_centre += plasticity->stress(zone, where, when);
    return at_centre;
  }
  const ZoneElement& element = stiffness.element(mesh.solid[zone]);
  const bool top = where == Plasticity::Where::top;
  Vec6 found = stress_of(mesh, zone, top ? element.top_stress : element.centre_stress, u);
  if (plasticity) found += plasticity->stress(zone, where, when);
  return found;
}

// Mean over the zones below the node, each amid its top face, where the recovered stress is best.
// Pa, sigma_z, tension positive. The owner holds all these zones.
double Ground::Room::surface_stress(std::int32_t node) const {
  if (mesh.imported) return imported_surface_stress(node);
  std::array<Id, 8> zones{};
  const int count = mesh.lattice.zones_at(mesh.node[static_cast<std::size_t>(node)], zones);
  double sum = 0;
  for (int z = 0; z < count; ++z) {
    const auto zone = static_cast<std::size_t>(mesh.local_zone(zones[static_cast<std::size_t>(z)]));
    sum += stress(zone, Plasticity::Where::top, Plasticity::When::since)(2);
  }
  return sum / count;
}

// The same over the faces around the node.
double Ground::Room::imported_surface_stress(std::int32_t node) const {
  double sum = 0;
  int count = 0;
  auto at = std::lower_bound(faces_at.begin(), faces_at.end(), std::pair(node, 0));
  for (; at != faces_at.end() && at->first == node; ++at, ++count) {
    const Imported::Face& face = mesh.imported->top[static_cast<std::size_t>(at->second)];
    const auto zone = static_cast<std::size_t>(face.zone);
    const Vec3 xi = tetrahedron_face_centre(face.side);
    sum += stiffness.tetrahedra().stress(zone, xi, state.displacement)(2);
    if (plasticity) sum += plasticity->stress_at(zone, xi, Plasticity::When::since)(2);
  }
  return sum / count;
}

// Ascending, as the surface counts.
std::vector<std::int32_t> Ground::own_top() const {
  std::vector<std::int32_t> numbers;
  for (const TopNode& top : room_->own_top) numbers.push_back(top.number);
  return numbers;
}

// Where an own node of the surface lives. Both faces of a plane model show the plane node.
std::int32_t Ground::Room::node_of_top(std::int32_t number) const {
  const auto found =
      std::lower_bound(own_top.begin(), own_top.end(), number,
                       [](const TopNode& t, std::int32_t n) { return t.number < n; });
  require(found != own_top.end() && found->number == number, "top node: not an own one");
  return found->node;
}

Ground::TopState Ground::top_state(std::int32_t number) const {
  const std::int32_t node = room_->node_of_top(number);
  const State& state = room_->state;
  return {room_->at_top(state.displacement, node), room_->at_top(state.velocity, node),
          room_->at_top(state.acceleration, node), room_->surface_stress(node)};
}

Ground::TopMotion Ground::top_motion(std::int32_t number) const {
  const std::int32_t node = room_->node_of_top(number);
  const State& state = room_->state;
  return {room_->at_top(state.displacement, node), room_->at_top(state.velocity, node),
          room_->at_top(state.acceleration, node)};
}

double Ground::top_mass(std::int32_t number) const {
  const std::int32_t node = room_->node_of_top(number);
  if (room_->flat_top) return room_->flat_top->mass(node);
  const auto at = static_cast<std::size_t>(node);
  return room_->terms.mass[at] / room_->mesh.lattice.shown(room_->mesh.node[at]);
}

// Of the motion since rest: 1/2 v M v and 1/2 u K u with the springs. Over own nodes: each once.
void Ground::Room::add_energies(GroundTotals& totals) const {
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
    for (const double stored : plasticity->stored(state.rest, state.displacement))
      elastic.push_back(stored);
    totals.plastic = sum_of(mesh.comm, plasticity->lost());
  }
  totals.kinetic = sum_of(mesh.comm, kinetic);
  totals.elastic = sum_of(mesh.comm, elastic);
}

GroundTotals Ground::totals() const {
  const Room& room = *room_;
  const Mesh& mesh = room.mesh;
  GroundTotals totals;
  totals.elements = mesh.zone_count();
  totals.nodes = mesh.node_count();
  totals.steps = room.steps;
  totals.seconds = room.seconds;
  if (room.solves > 0)
    totals.iterations_mean =
        static_cast<double>(room.iterations) / static_cast<double>(room.solves);
  if (room.newton_steps > 0)
    totals.rounds_mean = static_cast<double>(room.rounds) / static_cast<double>(room.newton_steps);
  totals.rounds_most = static_cast<double>(room.most_rounds);
  totals.lagging_steps = room.lagging_steps;
  totals.rounds_left = room.left;
  room.add_energies(totals);
  totals.springs = mesh.comm.max(room.terms.springs.empty() ? 0.0 : 1.0) > 0;
  std::int64_t unknowns = 0;
  for (const std::int32_t n : mesh.own)
    for (int c = 0; c < room.components(); ++c)
      unknowns += (room.terms.held[static_cast<std::size_t>(n)] >> c & 1) == 0 ? 1 : 0;
  totals.unknowns = mesh.comm.sum(unknowns);
  return totals;
}

double Ground::seconds() const { return room_->seconds; }

// Bytes on this rank; PETSc's matrices are not known here.
std::size_t Ground::memory() const {
  const Room& room = *room_;
  const std::size_t per_nodal = room.state.displacement.bytes();
  // The state and what the scheme derives: explicit four, implicit five (Newton's left out).
  const std::size_t nodals = room.parameters.integrator == Integrator::explicit_ ? 8 + 4 : 10 + 5;
  const std::size_t plastic = room.plasticity ? room.plasticity->bytes() : 0;
  return room.mesh.bytes() + room.terms.bytes() + room.stiffness.bytes() + nodals * per_nodal +
         plastic + (room.flat_top ? room.flat_top->bytes() : 0);
}

}  // namespace trackbed::fem
