// Surfaces are added and removed by stages: floor and walls with the fill, the platen for some
// stages, sleepers permanently. Each time all surfaces are registered again with stones and
// coupler. Rejected: surfaces that exist from the start and are switched off; every module would
// need the switch.
#include "model/scene/world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "trackbed/core/error.hpp"

namespace trackbed::model {

// The ground and the sleepers exist from the start, because their sizes are widths of the
// histories; sleepers act once they are placed.
World::World(const par::Comm& world, const Model& deck)
    : comm(world),
      model(deck),
      particles(world, deck.physics, deck.dem, deck.domain()),
      walls(deck.container(), deck.material(deck.wall_material),
            deck.ground.present ? -1 : deck.material(deck.ground_material)),
      coupler(world) {
  particles.set_breakage(model.breakage);
  particles.set_bonds(model.bonds);
  const double thickness = model.domain().thickness;
  if (model.ground.present) {
    ground.emplace(comm, model.ground, model.dimension, thickness);
    ground->top().material = model.material(model.ground_material);
    support.assign(ground->top().nodes(), Vec3::Zero());
    watched = observe::monitored_nodes(*ground, model.dimension);
    if (!model.pressures.empty())
      pressures.emplace(comm, ground->top(), model.ground.periodic(0), model.pressures);
  }
  if (model.is_placed()) placement.emplace(comm, model);
  if (!model.uses_sleepers()) return;
  if (model.sleepers.model == track::SleeperBody::solid) {
    auto made = std::make_unique<SolidSleepers>(model);
    solids = made.get();
    sleepers = std::move(made);
  } else {
    sleepers = std::make_unique<track::RigidSleepers>(model.sleepers, model.dimension, thickness,
                                                      model.material(model.sleepers.material));
  }
}

// Called by everything that changes surfaces, so that stones, coupler and numbers always agree.
// Costs a new partition of the stones and a new connection of the coupler, so it is for stages, not
// for windows.
void World::register_surfaces() {
  // By name, since numbers change: the ground keeps its load, and a new surface begins without
  // load.
  const std::vector<Means> kept = means();
  for (auto& part : registered_) part.clear();
  coupler.clear();
  std::vector<Surface*> surfaces;
  const auto add = [&](SurfaceId::Part part, Surface& surface, std::vector<int> owner = {}) {
    registered_[static_cast<std::size_t>(part)].push_back(
        {&surface, coupler.add(surface, std::move(owner))});
    surfaces.push_back(&surface);
  };
  using Part = SurfaceId::Part;
  if (ground) add(Part::ground, ground->top(), ground->top_owner());
  for (Surface& side : walls.surfaces()) add(Part::wall, side);
  if (placement)
    for (Surface& surface : placement->surfaces()) add(Part::placed, surface);
  if (sleepers && sleepers->placed())
    for (Surface& body : sleepers->surfaces()) add(Part::sleeper, body);
  if (platen) add(Part::platen, platen->surface());
  if (tines)
    for (Surface& side : tines->surfaces()) add(Part::tine, side);
  particles.set_surfaces(surfaces);
  set_means(kept);
  share_out();
}

void make_bonds(World& world, const Stage& stage) {
  const auto number = static_cast<std::size_t>(&stage - world.model.stages.data());
  for (std::size_t kind = 0; kind < world.model.bonds.size(); ++kind)
    if (world.model.bonds[kind].present && world.model.bonds_from(kind) == number)
      world.particles.bond(kind);
}

void World::share_out() {
  particles.repartition();
  connect();
}

void World::rebalance() {
  if (particles.rebalance()) connect();
}

// The nodes a rank needs follow from the positions of its stones: coupler after stones.
void World::connect() {
  coupler.connect([&](const Vec3& low, const Vec3& high) { return particles.reaches(low, high); });
}

// At rest, its lower face at height z, m.
void World::place_platen(double z) {
  platen.emplace(model.platen, model.container(), model.material(model.wall_material));
  platen->place(z);
  register_surfaces();
}

void World::take_platen_away() {
  platen.reset();
  register_surfaces();
}

bed::Tines World::make_tines() const {
  bed::TampedSleepers tamped{.width = model.sleepers.width};
  for (std::size_t i = 0; i < sleepers->count(); ++i) tamped.x.push_back(sleepers->x(i));
  return {model.tamping, tamped, model.dimension, model.domain().thickness,
          model.material(model.sleepers.material)};
}

// The depth is relative to the lowest sleeper. Tines have the contact material of sleepers.
void World::place_tines() {
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < sleepers->count(); ++i)
    lowest = std::min(lowest, sleepers->bottom() + sleepers->state(i).displacement.z());
  tines.emplace(make_tines());
  tines->set_heights(top_of_stones(), lowest + model.tamping.lift);
  if (tines->tip() <= 0)
    throw RunError(
        fmt::format("the tips of the tines would reach z = {:.4g} m, below the floor of "
                    "the bed: reduce tamping.depth",
                    tines->tip()));
  register_surfaces();
}

void World::take_tines_away() {
  tines.reset();
  register_surfaces();
}

// Computes the initial forces in a window too short for any motion, with fixed surfaces: so forces
// of initial contacts act from the first sub-step on and not from the second.
void World::place_stones() {
  constexpr double instant = 1e-30;  // s
  placement->place(particles);
  placement->update(0, 0);
  register_surfaces();
  coupler.publish();
  particles.advance(instant, 1);
  collect_loads(instant, 1);
  placement->begin(particles, forces_on(SurfaceId::Part::placed));
}

void World::collect_loads(double dt, int substeps) {
  const dem::SurfaceAction& did = particles.surface_action();
  coupler.collect(substeps, dt, {did.force, did.moment, did.work});
  particles.expect_load(coupler.largest_load());
}

void World::expect_weight(int substeps) {
  particles.expect_load(particles.totals().mass * model.dem.gravity * substeps);
}

// Minus infinity without stones. A hull of spheres is as high as the highest of them.
double World::top_of_stones() const {
  double top = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < particles.size(); ++i)
    particles.corners(
        i, [&](const Vec3& centre, double radius) { top = std::max(top, centre.z() + radius); });
  return comm.max(top);
}

// From the nodes' displacements, so that it is exactly 0 on a ground that never moved. The last
// bits of the sum depend on the number of ranks: only for figures, never used in the motion.
double World::mean_ground_level() const {
  if (!ground) return 0;
  double sum = 0;
  for (const std::int32_t own : ground->own_top()) sum += ground->top_state(own).displacement.z();
  return comm.sum(sum) / static_cast<double>(ground->top_owner().size());
}

std::span<const Vec3> World::nodal_force_on(SurfaceId id) const {
  const std::vector<Registered>& part = registered(id.part);
  if (id.index >= part.size()) return {};
  return coupler.mean_force(part[id.index].number);
}

// Summed in the order of nodes: bitwise identical on every rank.
Vec3 World::force_on(SurfaceId id) const {
  Vec3 force = Vec3::Zero();
  for (const Vec3& node : nodal_force_on(id)) force += node;
  return force;
}

std::vector<std::span<const Vec3>> World::nodal_forces_on(SurfaceId::Part part) const {
  std::vector<std::span<const Vec3>> forces;
  for (std::size_t i = 0; i < registered(part).size(); ++i)
    forces.push_back(nodal_force_on({part, i}));
  return forces;
}

std::vector<Vec3> World::forces_on(SurfaceId::Part part) const {
  std::vector<Vec3> forces;
  for (std::size_t i = 0; i < registered(part).size(); ++i) forces.push_back(force_on({part, i}));
  return forces;
}

SurfaceId World::wall(const std::string& name) const {
  const std::vector<Registered>& part = registered(SurfaceId::Part::wall);
  std::size_t i = 0;
  while (i < part.size() && part[i].surface->name != name) ++i;
  return {SurfaceId::Part::wall, i};
}

observe::Scene World::scene() {
  using Shown = observe::SceneSurface;
  using Part = SurfaceId::Part;
  std::vector<Shown> shown;
  for (const auto& [part, as] :
       {std::pair(Part::wall, Shown::Part::wall), std::pair(Part::placed, Shown::Part::placed),
        std::pair(Part::sleeper, Shown::Part::sleeper),
        std::pair(Part::platen, Shown::Part::platen), std::pair(Part::tine, Shown::Part::tine)})
    for (const Registered& each : registered(part))
      shown.push_back({as, each.surface, each.number});
  return {.particles = particles,
          .ground = ground ? &*ground : nullptr,
          .sleepers = sleepers && sleepers->placed() ? &*sleepers : nullptr,
          .bodies = solids && solids->placed() ? &solids->bodies() : nullptr,
          .gravity = model.dem.gravity,
          .stones = model.has_stones(),
          .breaks = model.breakage.any(),
          .bonds = !model.bonds.empty(),
          .surfaces = std::move(shown)};
}

std::vector<observe::WallState> World::wall_states() const {
  std::vector<observe::WallState> states;
  for (const std::string& name : walls.names())
    states.push_back({name, force_on(wall(name)), walls.displacement(name)});
  if (!model.has_stage(StageKind::tamp)) return states;
  std::size_t side = 0;
  for (const std::string& name : bed::Tines::names())
    states.push_back({name, force_on({SurfaceId::Part::tine, side++}),
                      tines ? tines->displacement(name) : Vec3::Zero()});
  return states;
}

observe::PlatenState World::platen_state() const {
  if (!platen) return {};
  return {.z = platen->z(),
          .pressure = platen->pressure(),
          .force = force_on({SurfaceId::Part::platen})};
}

std::size_t World::memory() const {
  return particles.memory().total() + (ground ? ground->memory() : 0) +
         (solids ? solids->bodies().memory() : 0);
}

// Only the owner of a node has its mean, all others add zero: the sum is exact.
std::vector<World::Means> World::means() const {
  std::vector<Means> all;
  for (const auto& part : registered_)
    for (const Registered& one : part) {
      Means means{one.surface->name, coupler.save_mean(one.number)};
      comm.sum(std::span<double>(means.force.empty() ? nullptr : means.force[0].data(),
                                 3 * means.force.size()));
      all.push_back(std::move(means));
    }
  return all;
}

// A new surface, or one with another number of nodes, begins without load.
void World::set_means(const std::vector<Means>& means) {
  for (const auto& part : registered_)
    for (const Registered& one : part)
      for (const Means& kept : means)
        if (kept.surface == one.surface->name && kept.force.size() == one.surface->nodes())
          coupler.load_mean(one.number, kept.force);
}

}  // namespace trackbed::model
