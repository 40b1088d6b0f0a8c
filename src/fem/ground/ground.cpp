// The interface of the ground and its surface. Time stepping is in explicit.cpp and implicit.cpp,
// output in output.cpp, restart in checkpoint.cpp.
#include "trackbed/fem/ground.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "fem/ground/impl.hpp"
#include "fem/shape/tetrahedron.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/core/exact_sum.hpp"
#include "trackbed/core/whole_steps.hpp"

namespace trackbed::fem {

namespace {

// One element per solid: all elements of a solid have the same size.
std::vector<ElementMatrices> matrices_of(const Mesh& mesh, const GroundParameters& parameters) {
  std::vector<ElementMatrices> matrices;
  if (mesh.imported) return matrices;
  const Dimension dimension = mesh.lattice.plane ? Dimension::plane : Dimension::space;
  for (std::size_t s = 0; s < mesh.solids.solid.size(); ++s)
    matrices.push_back(
        element_matrices(mesh.solids.size[s], mesh.solids.solid[s], dimension, parameters.plane));
  return matrices;
}

// Largest sum of forces on a node that the exact sums of the surface must represent, N. A tenth of
// a million tons on one node: far beyond any track, and the quantum is still far below the force of
// a grain. Loads are summed as integers of this quantum.
constexpr double largest_node_force = 1e9;

}  // namespace

Ground::Impl::Impl(const par::Comm& comm, const GroundParameters& given, Dimension dim,
                   double thickness)
    : parameters(given),
      dimension(dim),
      mesh(comm, given, dim, thickness),
      stiffness(mesh, matrices_of(mesh, given), given.rayleigh_stiffness),
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

// Node number: i + (nx + 1) j; two triangles per element, counter-clockwise seen from above. Every
// rank has the whole top: the coupler needs all boxes, and a top is small compared with the solid.
// A plane model has two lines of surface nodes, front and back, that share one plane node each.
void Ground::Impl::make_surface() {
  if (mesh.imported) return import_surface();
  const Lattice& lattice = mesh.lattice;
  const std::int64_t row = lattice.points()[0], across = lattice.plane ? 2 : lattice.points()[1];
  surface.name = "ground";
  surface.load_quantum = exact_quantum(largest_node_force);
  for (std::int64_t j = 0; j < across; ++j)
    for (std::int64_t i = 0; i < row; ++i) {
      const Id id = lattice.node({i, lattice.plane ? 0 : j, lattice.elements[2]});
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

// Six-node faces as four triangles each, so that stones and nodal loads act on plane facets;
// flat_top.hpp defines their motion. Collective.
void Ground::Impl::import_surface() {
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
          shape.corner[static_cast<std::size_t>(face.element)][static_cast<std::size_t>(k)],
          number);
    ++number;
  }
  std::sort(faces_at.begin(), faces_at.end());
  finish_surface();
}

void Ground::Impl::finish_surface() {
  for (const TopNode& top : own_top) top_nodes.push_back(top.node);
  std::sort(top_nodes.begin(), top_nodes.end());
  top_nodes.erase(std::unique(top_nodes.begin(), top_nodes.end()), top_nodes.end());
  surface.motion.assign(surface.nodes(), Vec3::Zero());
  surface.clear_load();
  window_start_.assign(own_top.size(), Vec3::Zero());
}

// Components of the model as a vector in space; a plane model has no y.
Vec3 Ground::Impl::vector(const Nodal& values, std::int32_t node) const {
  Vec3 v = Vec3::Zero();
  for (int c = 0; c < components(); ++c) v[mesh.lattice.axis(c)] = values[c][node];
  return v;
}

Vec3 Ground::Impl::at_top(const Nodal& values, std::int32_t node) const {
  return flat_top ? flat_top->at(node, values) : vector(values, node);
}

// Displacement of the shape that stones touch: settling moves the reference, not the surface.
Vec3 Ground::Impl::shown_displacement(std::int32_t node) const {
  return at_top(state.offset, node) + at_top(state.displacement, node);
}

// Only the top carries external load; weight is part of static equilibrium. Collective for a ground
// of tetrahedra.
void Ground::Impl::set_load(std::span<const Vec3> top_force) {
  require(top_force.size() == surface.nodes(), "ground: one force per top node");
  for (const std::int32_t node : top_nodes)
    for (int c = 0; c < components(); ++c) state.load[c][node] = 0;
  // Loads on both faces of a plane ground and on both ends of a periodic ground are summed.
  for (const TopNode& top : own_top)
    for (int c = 0; c < components(); ++c)
      state.load[c][top.node] +=
          top_force[static_cast<std::size_t>(top.number)][mesh.lattice.axis(c)];
  if (flat_top) flat_top->to_nodes(state.load);
  for (const std::int32_t node : top_nodes)
    for (int c = 0; c < components(); ++c) state.load[c][node] -= state.settled[c][node];
}

// There is no motion yet, so only the load accelerates. Otherwise the first kick would be half as
// large, and all motion half a step late. Collective as `set_load`.
void Ground::Impl::initialise_acceleration(std::span<const Vec3> top_force) {
  set_load(top_force);
  for (const std::int32_t node : top_nodes)
    for (int c = 0; c < components(); ++c) {
      const auto n = static_cast<std::size_t>(node);
      const bool moves = mesh.owned[n] != 0 && (terms.held[n] >> c & 1) == 0;
      state.acceleration[c][n] = moves ? state.load[c][n] / terms.mass[n] : 0;
    }
}

// The surface of the window just ended: positions at its start and motion over it. Collective.
// Stones follow this motion linearly while the ground is already at its end.
void Ground::Impl::publish() {
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

// Corners of a mesh depend on the nodes around them, also those of other ranks.
void Ground::Impl::show_motion() {
  if (!flat_top) return;
  for (Nodal* values : {&state.displacement, &state.velocity, &state.acceleration})
    mesh.exchange(*values);
}

// After construction, settling, loading: a surface without motion at the position of the state.
void Ground::Impl::refresh_surface() {
  show_motion();
  for (std::size_t t = 0; t < own_top.size(); ++t)
    window_start_[t] = shown_displacement(own_top[t].node);
  publish();
}

// Divergence anywhere reaches the top within as many steps as there are elements in between. Local:
// the agreement of ranks in each window informs the others.
void Ground::Impl::check_finite() {
  for (std::size_t t = 0; t < own_top.size(); ++t)
    if (!window_start_[t].allFinite()) {
      trouble = "the ground diverges: top node " + std::to_string(own_top[t].number) +
                " has no finite displacement; reduce the time step (ground.safety; with implicit "
                "steps time.window, or passage.step with model = \"track_on_ground\")";
      return;
    }
}

Ground::Ground(const par::Comm& comm, const GroundParameters& parameters, Dimension dimension,
               double thickness)
    : impl_(std::make_unique<Impl>(comm, parameters, dimension, thickness)) {}
Ground::~Ground() = default;
Ground::Ground(Ground&&) noexcept = default;

// s. `limit` is set to what limits the step, for the log.
double Ground::stable_step(std::string* limit) const {
  const bool implicit = is_implicit();
  if (limit != nullptr) *limit = implicit ? "nothing: implicit" : impl_->limit;
  // Implicit steps are stable at any length; accuracy is the choice of the caller.
  if (implicit) return std::numeric_limits<double>::infinity();
  return impl_->parameters.safety * impl_->critical;
}

bool Ground::is_implicit() const { return impl_->parameters.integrator != Integrator::explicit_; }

Surface& Ground::top() { return impl_->surface; }
const std::vector<int>& Ground::top_owner() const { return impl_->mesh.top_owner; }
std::string Ground::trouble() const { return impl_->trouble; }

bool Ground::settle(std::span<const Vec3> top_force, const StaticMonitor& monitor) {
  return impl_->settle(top_force, monitor);
}
void Ground::initialise_acceleration(std::span<const Vec3> top_force) {
  impl_->initialise_acceleration(top_force);
}
void Ground::try_solvers(double dt) { impl_->try_solvers(dt); }

// Collective. The load of the whole window is the mean force of the stones in the last one
// (docs/architecture.md, The step).
void Ground::advance(double dt, std::span<const Vec3> top_force) {
  if (is_implicit()) return advance(dt, [&](double) { return top_force; });
  impl_->set_load(top_force);  // from the start of the window on
  advance(dt, LoadInWindow());
}

void Ground::advance(double dt, const LoadInWindow& load) {
  const auto begin = std::chrono::steady_clock::now();
  if (is_implicit()) {
    const Nodal before = impl_->state.load;
    impl_->set_load(load(dt));
    impl_->implicit_window(dt, before);
  } else {
    impl_->explicit_window(dt, load);
  }
  impl_->time += dt;
  impl_->publish();
  impl_->seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// Explicit: local except for ghosts. A step that is too long would show only as divergence.
void Ground::begin_step(double dt, std::span<const Vec3> expected) {
  const auto begin = std::chrono::steady_clock::now();
  require(dt <= stable_step() * (1 + rounding_of_steps), "half steps of the ground must be stable");
  impl_->step_in_halves = dt;
  if (is_implicit()) {
    const Nodal before = impl_->state.load;
    impl_->set_load(expected);
    impl_->expected = impl_->state.load;
    impl_->implicit_window(dt, before);
    impl_->show_motion();
  } else {
    impl_->begin_step(dt);
  }
  impl_->seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void Ground::end_step(std::span<const Vec3> top_force) {
  const auto begin = std::chrono::steady_clock::now();
  impl_->set_load(top_force);
  if (is_implicit())
    impl_->correct_window(impl_->step_in_halves, impl_->expected);
  else
    impl_->end_step(impl_->step_in_halves);
  impl_->time += impl_->step_in_halves;
  impl_->publish();
  impl_->seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

std::vector<Vec3> Ground::deflection(double dt, std::span<const Vec3> top_force) {
  const Nodal before = impl_->state.load;
  impl_->set_load(top_force);
  Nodal moved = impl_->deflection(dt);
  impl_->state.load = before;
  if (impl_->flat_top) impl_->mesh.exchange(moved);
  std::vector<Vec3> deflections;
  for (const TopNode& top : impl_->own_top) deflections.push_back(impl_->at_top(moved, top.node));
  return deflections;
}

}  // namespace trackbed::fem
