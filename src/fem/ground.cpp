// The door of the ground and its surface. Time stepping is in explicit.cpp and implicit.cpp, output
// in output.cpp, restart in checkpoint.cpp.
#include "trackbed/fem/ground.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "room.hpp"
#include "tetrahedron.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/exact_sum.hpp"

namespace trackbed::fem {

namespace {

// One element per solid: all its zones have the same size.
std::vector<ZoneElement> elements_of(const Mesh& mesh, const GroundParameters& parameters) {
  std::vector<ZoneElement> elements;
  if (mesh.imported) return elements;
  const Dimension dimension = mesh.lattice.plane ? Dimension::plane : Dimension::space;
  for (std::size_t s = 0; s < mesh.solids.solid.size(); ++s)
    elements.push_back(
        zone_element(mesh.solids.size[s], mesh.solids.solid[s], dimension, parameters.plane));
  return elements;
}

// Largest sum of forces on a node the exact sums of the surface must hold, N.
// A tenth of a million tons on one node: far beyond any track, and the quantum is still far below
// the force of a grain. Loads are summed as integers of this quantum.
constexpr double largest_node_force = 1e9;

}  // namespace

Ground::Room::Room(const par::Comm& comm, const GroundParameters& given, Dimension dim,
                   double thickness)
    : parameters(given),
      dimension(dim),
      mesh(comm, given, dim, thickness),
      stiffness(mesh, elements_of(mesh, given), given.rayleigh_stiffness),
      terms(mesh, given, stiffness),
      state(components(), mesh.nodes(), given.integrator != Integrator::explicit_) {
  critical = critical_step(mesh, parameters, stiffness, limit);
  if (parameters.yields())
    plasticity =
        std::make_unique<Plasticity>(mesh, mesh.imported ? &stiffness.tetrahedra() : nullptr);
  if (!parameters.base_motion.empty())
    free_field = std::make_unique<FreeField>(mesh, parameters, stiffness);
  make_surface();
  refresh_surface();
}

// Node number: i + (nx + 1) j; two triangles per zone, counter-clockwise seen from above.
// The whole top on every rank: the coupler needs all boxes, and a top is small beside the solid. A
// plane model shows two lines of nodes, front and back, that share one plane node each.
void Ground::Room::make_surface() {
  if (mesh.imported) return import_surface();
  const Lattice& lattice = mesh.lattice;
  const std::int64_t row = lattice.points()[0], across = lattice.plane ? 2 : lattice.points()[1];
  surface.name = "ground";
  surface.load_quantum = exact_quantum(largest_node_force);
  for (std::int64_t j = 0; j < across; ++j)
    for (std::int64_t i = 0; i < row; ++i) {
      const Id id = lattice.node({i, lattice.plane ? 0 : j, lattice.zones[2]});
      Vec3 x = lattice.position(id);
      if (lattice.plane) x.y() = lattice.low.y() + static_cast<double>(j) * lattice.size.y();
      const auto number = static_cast<std::int32_t>(surface.position.size());
      surface.position.push_back(x);
      const std::int32_t node = mesh.local_node(id);
      const std::int32_t home = node < 0 ? node : mesh.home(node);
      if (home >= 0 && mesh.owned[static_cast<std::size_t>(home)] != 0)
        own_top.push_back({number, home, x});
    }
  for (std::int64_t j = 0; j + 1 < across; ++j)
    for (std::int64_t i = 0; i + 1 < row; ++i) {
      const auto a = static_cast<std::int32_t>(i + row * j), b = a + 1;
      const auto d = static_cast<std::int32_t>(a + row), c = d + 1;
      surface.triangles.push_back({a, b, c});
      surface.triangles.push_back({a, c, d});
    }
  finish_surface();
}

// Six-node faces as four triangles each, so that stones and nodal loads see straight pieces;
// flat_top.hpp says how they move. Collective.
void Ground::Room::import_surface() {
  const Imported& shape = *mesh.imported;
  surface.name = "ground";
  surface.load_quantum = exact_quantum(largest_node_force);
  flat_top = std::make_unique<FlatTop>(mesh, terms.mass);
  surface.position = shape.top_place;
  surface.triangles = shape.top_triangles;
  for (std::size_t n = 0; n < shape.top_node.size(); ++n) {
    const std::int32_t node = mesh.local_node(shape.top_node[n]);
    if (node >= 0 && mesh.owned[static_cast<std::size_t>(node)] != 0)
      own_top.push_back({static_cast<std::int32_t>(n), node, shape.top_place[n]});
  }
  for (std::int32_t number = 0; const Imported::Face& face : shape.top) {
    for (const int k : tetrahedron_faces[static_cast<std::size_t>(face.side)])
      faces_at.emplace_back(
          shape.corner[static_cast<std::size_t>(face.zone)][static_cast<std::size_t>(k)], number);
    ++number;
  }
  std::sort(faces_at.begin(), faces_at.end());
  finish_surface();
}

void Ground::Room::finish_surface() {
  for (const TopNode& top : own_top) top_nodes.push_back(top.node);
  std::sort(top_nodes.begin(), top_nodes.end());
  top_nodes.erase(std::unique(top_nodes.begin(), top_nodes.end()), top_nodes.end());
  surface.motion.assign(surface.nodes(), Vec3::Zero());
  surface.clear_load();
  window_start_.assign(own_top.size(), Vec3::Zero());
}

// Components of the model as a vector in space; a plane has no y.
Vec3 Ground::Room::vector(const Nodal& values, std::int32_t node) const {
  Vec3 v = Vec3::Zero();
  for (int c = 0; c < components(); ++c) v[mesh.lattice.axis(c)] = values[c][node];
  return v;
}

Vec3 Ground::Room::at_top(const Nodal& values, std::int32_t node) const {
  return flat_top ? flat_top->at(node, values) : vector(values, node);
}

// Of the shape the stones touch: settling moves the reference, not the surface.
Vec3 Ground::Room::shown_displacement(std::int32_t node) const {
  return at_top(state.offset, node) + at_top(state.displacement, node);
}

// Only the top carries load from outside; weight is in the state of rest. Collective if it is that
// of a mesh.
void Ground::Room::set_load(std::span<const Vec3> top_force) {
  require(top_force.size() == surface.nodes(), "ground: one force per top node");
  for (const std::int32_t node : top_nodes)
    for (int c = 0; c < components(); ++c) state.load[c][node] = 0;
  // Both faces of a plane, both ends of a periodic ground add up.
  for (const TopNode& top : own_top)
    for (int c = 0; c < components(); ++c)
      state.load[c][top.node] +=
          top_force[static_cast<std::size_t>(top.number)][mesh.lattice.axis(c)];
  if (flat_top) flat_top->to_nodes(state.load);
  for (const std::int32_t node : top_nodes)
    for (int c = 0; c < components(); ++c) state.load[c][node] -= state.settled[c][node];
}

// Nothing has moved yet, so nothing else accelerates. Without it the first kick would be half a
// one, and all that follows half a step late. Collective as `set_load`.
void Ground::Room::begin_under(std::span<const Vec3> top_force) {
  set_load(top_force);
  for (const std::int32_t node : top_nodes)
    for (int c = 0; c < components(); ++c) {
      const auto n = static_cast<std::size_t>(node);
      const bool moves = mesh.owned[n] != 0 && (terms.held[n] >> c & 1) == 0;
      state.acceleration[c][n] = moves ? state.load[c][n] / terms.mass[n] : 0;
    }
}

// The surface of the window that just ended: where its nodes were and how far they went.
// Collective. The stones follow this motion linearly while the ground already stands at its end.
void Ground::Room::publish() {
  flat_top ? show_motion() : mesh.exchange(state.displacement);
  for (std::size_t t = 0; t < own_top.size(); ++t) {
    const TopNode& top = own_top[t];
    const auto number = static_cast<std::size_t>(top.number);
    const Vec3 now = shown_displacement(top.node);
    surface.position[number] = top.place + window_start_[t];
    surface.motion[number] = now - window_start_[t];
    window_start_[t] = now;
  }
  check_finite();
}

// Corners of a mesh show what the nodes around do, of other ranks too.
void Ground::Room::show_motion() {
  if (!flat_top) return;
  for (Nodal* values : {&state.displacement, &state.velocity, &state.acceleration})
    mesh.exchange(*values);
}

// After construction, settling, loading: a surface at rest where the state says.
void Ground::Room::refresh_surface() {
  show_motion();
  for (std::size_t t = 0; t < own_top.size(); ++t)
    window_start_[t] = shown_displacement(own_top[t].node);
  publish();
}

// What diverges anywhere reaches the top within as many steps as there are zones in between.
// Local: the window's agreement tells the others.
void Ground::Room::check_finite() {
  for (std::size_t t = 0; t < own_top.size(); ++t)
    if (!window_start_[t].allFinite()) {
      trouble = "the ground diverges: top node " + std::to_string(own_top[t].number) +
                " has no finite displacement";
      return;
    }
}

Ground::Ground(const par::Comm& comm, const GroundParameters& parameters, Dimension dimension,
               double thickness)
    : room_(std::make_unique<Room>(comm, parameters, dimension, thickness)) {}
Ground::~Ground() = default;
Ground::Ground(Ground&&) noexcept = default;

// s. The words name what limits it, for the log.
double Ground::stable_step(std::string* limit) const {
  const bool implicit = is_implicit();
  if (limit != nullptr) *limit = implicit ? "nothing: implicit" : room_->limit;
  // Implicit steps are stable at any length; accuracy is the caller's choice.
  if (implicit) return std::numeric_limits<double>::infinity();
  return room_->parameters.safety * room_->critical;
}

bool Ground::is_implicit() const { return room_->parameters.integrator != Integrator::explicit_; }

Surface& Ground::top() { return room_->surface; }
const std::vector<int>& Ground::top_owner() const { return room_->mesh.top_owner; }
std::string Ground::trouble() const { return room_->trouble; }

bool Ground::settle(std::span<const Vec3> top_force, const GoOn& go_on) {
  return room_->settle(top_force, go_on);
}
void Ground::begin_under(std::span<const Vec3> top_force) { room_->begin_under(top_force); }
void Ground::try_solvers(double dt) { room_->try_solvers(dt); }

// Collective. The load of the whole window is the stones' mean of the last one; see app's
// simulation for the scheme.
void Ground::advance(double dt, std::span<const Vec3> top_force) {
  const auto begin = std::chrono::steady_clock::now();
  const bool implicit = is_implicit();
  const Nodal before = implicit ? room_->state.load : Nodal();
  room_->set_load(top_force);
  if (implicit)
    room_->implicit_window(dt, before);
  else
    room_->explicit_window(dt);
  room_->time += dt;
  room_->publish();
  room_->seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// Explicit: local but for ghosts. A step that is too long would only show as divergence.
void Ground::begin_step(double dt, std::span<const Vec3> expected) {
  const auto begin = std::chrono::steady_clock::now();
  constexpr double rounding = 1e-9;
  require(dt <= stable_step() * (1 + rounding), "a ground in halves of steps takes stable ones");
  room_->step_in_halves = dt;
  if (is_implicit()) {
    const Nodal before = room_->state.load;
    room_->set_load(expected);
    room_->expected = room_->state.load;
    room_->implicit_window(dt, before);
    room_->show_motion();
  } else {
    room_->begin_step(dt);
  }
  room_->seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void Ground::end_step(std::span<const Vec3> top_force) {
  const auto begin = std::chrono::steady_clock::now();
  room_->set_load(top_force);
  if (is_implicit())
    room_->correct_window(room_->step_in_halves, room_->expected);
  else
    room_->end_step(room_->step_in_halves);
  room_->time += room_->step_in_halves;
  room_->publish();
  room_->seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::vector<Vec3> Ground::give_way(double dt, std::span<const Vec3> top_force) {
  const Nodal before = room_->state.load;
  room_->set_load(top_force);
  Nodal moved = room_->give_way(dt);
  room_->state.load = before;
  if (room_->flat_top) room_->mesh.exchange(moved);
  std::vector<Vec3> ways;
  for (const TopNode& top : room_->own_top) ways.push_back(room_->at_top(moved, top.node));
  return ways;
}

}  // namespace trackbed::fem
