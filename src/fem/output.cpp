// What leaves the ground as numbers: sensors of the top face, fields, totals, checkpoint.
//
// Stresses are those of the deviation, since settling; the fields give the stress at rest beside
// them, so that a reader may add both. Nothing here changes the state.
#include <algorithm>

#include "room.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

// xx yy zz xy yz zx, tension positive.
using Stress = Eigen::Matrix<double, 6, 1>;

// Stress at the point that `recovery` stands for, from the corner displacements.
Stress stress_of(const Mesh& mesh, std::size_t zone, const Eigen::MatrixXd& recovery,
                 const Nodal& u) {
  const int components = mesh.lattice.components();
  Stress stress = Stress::Zero();
  for (int k = 0; k < mesh.lattice.corners(); ++k)
    for (int c = 0; c < components; ++c)
      stress += recovery.col(k * components + c) * u[c][mesh.corner(zone, k)];
  return stress;
}

// Corners in VTK's order, as bits x, y, z.
constexpr std::array<int, 8> vtk_corner = {0, 1, 3, 2, 4, 5, 7, 6};

}  // namespace

// Mean over the zones below the node, each amid its top face, where the recovered stress is best.
// Pa, sigma_z, tension positive. The owner holds all these zones.
double Ground::Room::surface_stress(std::int32_t node) const {
  std::array<Id, 8> zones{};
  const int count = mesh.lattice.zones_at(mesh.node[static_cast<std::size_t>(node)], zones);
  double sum = 0;
  for (int z = 0; z < count; ++z) {
    const auto zone = static_cast<std::size_t>(mesh.local_zone(zones[static_cast<std::size_t>(z)]));
    const auto& element = stiffness.element(mesh.solid[zone]);
    sum += stress_of(mesh, zone, element.top_stress, state.displacement)(2);
  }
  return sum / count;
}

// Ascending, as the surface counts.
std::vector<std::int32_t> Ground::own_top() const {
  std::vector<std::int32_t> numbers;
  for (const TopNode& top : room_->own_top) numbers.push_back(top.number);
  return numbers;
}

// Both faces of a plane model show the plane node.
Ground::TopState Ground::top_state(std::int32_t number) const {
  const auto& own = room_->own_top;
  const auto found =
      std::lower_bound(own.begin(), own.end(), number,
                       [](const TopNode& t, std::int32_t n) { return t.number < n; });
  require(found != own.end() && found->number == number, "top_state: not an own node");
  const State& state = room_->state;
  return {room_->vector(state.displacement, found->node),
          room_->vector(state.velocity, found->node),
          room_->vector(state.acceleration, found->node), room_->surface_stress(found->node)};
}

// Points are all nodes this rank holds; those of ghosts that no own cell uses do no harm.
// Collective because of the velocities of ghosts.
io::Grid Ground::fields() const {
  const Mesh& mesh = room_->mesh;
  const Lattice& lattice = mesh.lattice;
  io::Grid grid;
  grid.kind = io::CellKind::hexahedron;
  io::FieldData displacement{"displacement (m)", 3, {}}, velocity{"velocity (m/s)", 3, {}};
  io::FieldData stress{"stress since settling, xx yy zz xy yz zx (Pa)", 6, {}};
  io::FieldData rest{"stress at rest, xx yy zz xy yz zx (Pa)", 6, {}}, solid{"solid", 1, {}};
  Nodal velocity_everywhere = room_->state.velocity;
  // Ghost velocities do not matter to the run; points of zones at rank borders show them.
  room_->mesh.exchange(velocity_everywhere);
  const std::size_t faces = lattice.plane ? 2 : 1;  // a plane node stands on both faces
  for (std::size_t n = 0; n < mesh.nodes(); ++n)
    for (std::size_t face = 0; face < faces; ++face) {
      const auto node = static_cast<std::int32_t>(n);
      Vec3 x = lattice.position(mesh.node[n]);
      if (lattice.plane) x.y() = lattice.low.y() + static_cast<double>(face) * lattice.size.y();
      const Vec3 u = room_->vector(room_->state.displacement, node);
      const Vec3 v = room_->vector(velocity_everywhere, node);
      grid.points.push_back(x);
      displacement.values.insert(displacement.values.end(), u.begin(), u.end());
      velocity.values.insert(velocity.values.end(), v.begin(), v.end());
    }
  for (std::size_t z = 0; z < mesh.zone.size(); ++z) {
    if (!mesh.writes(z)) continue;
    for (const int k : vtk_corner) {
      const int corner = lattice.plane ? (k & 1) | (k >> 2) << 1 : k;
      const std::int64_t face = lattice.plane ? k >> 1 & 1 : 0;
      grid.cells.push_back(mesh.corner(z, corner) * static_cast<std::int64_t>(faces) + face);
    }
    const auto& recovery = room_->stiffness.element(mesh.solid[z]).centre_stress;
    const Stress now = stress_of(mesh, z, recovery, room_->state.displacement);
    const Stress then = stress_of(mesh, z, recovery, room_->state.rest);
    stress.values.insert(stress.values.end(), now.begin(), now.end());
    rest.values.insert(rest.values.end(), then.begin(), then.end());
    solid.values.push_back(mesh.solid[z]);
  }
  grid.point_data = {displacement, velocity};
  grid.cell_data = {stress, rest, solid};
  return grid;
}

GroundTotals Ground::totals() const {
  const Room& room = *room_;
  const Mesh& mesh = room.mesh;
  GroundTotals totals;
  totals.elements = mesh.lattice.zone_count();
  totals.nodes = mesh.lattice.node_count();
  totals.steps = room.steps;
  totals.seconds = room.seconds;
  if (room.solves > 0)
    totals.iterations_mean =
        static_cast<double>(room.iterations) / static_cast<double>(room.solves);
  // Energies of the motion since rest: 1/2 v M v and 1/2 u K u with the springs.
  Nodal force(room.components(), mesh.nodes());
  room.stiffness.apply(room.state.displacement, force);
  for (const Spring& s : room.terms.springs)
    for (int c = 0; c < room.components(); ++c)
      force[c][s.node] += s.stiffness * room.state.displacement[c][s.node];
  // Over own nodes: each node once. Plain sums, for the eye: they feed nothing back.
  double kinetic = 0, elastic = 0;
  std::int64_t unknowns = 0;
  for (const std::int32_t n : mesh.own)
    for (int c = 0; c < room.components(); ++c) {
      const double v = room.state.velocity[c][n];
      const auto at = static_cast<std::size_t>(n);
      kinetic += 0.5 * room.terms.mass[at] * v * v;
      elastic += 0.5 * room.state.displacement[c][n] * force[c][n];
      unknowns += (room.terms.held[at] >> c & 1) == 0 ? 1 : 0;
    }
  totals.kinetic = mesh.comm.sum(kinetic);
  totals.elastic = mesh.comm.sum(elastic);
  totals.unknowns = mesh.comm.sum(unknowns);
  return totals;
}

// Bytes on this rank; PETSc's matrices are not known here.
std::size_t Ground::memory() const {
  const Room& room = *room_;
  const std::size_t per_nodal = room.state.displacement.bytes();
  constexpr std::size_t nodals = 8 + 4;  // the state and what the explicit scheme derives
  return room.mesh.bytes() + room.terms.bytes() + room.stiffness.bytes() + nodals * per_nodal;
}

}  // namespace trackbed::fem
