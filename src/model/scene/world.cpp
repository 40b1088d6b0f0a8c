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
  touched_.clear();
  coupler.clear();
  std::vector<Surface*> surfaces;
  const auto add = [&](Surface& surface, std::vector<int> owner = {}) {
    touched_.push_back({&surface, coupler.add(surface, std::move(owner))});
    surfaces.push_back(&surface);
    return touched_.back().number;
  };
  if (ground) add(ground->top(), ground->top_owner());
  for (Surface& wall : walls.surfaces()) add(wall);
  if (placement)
    for (Surface& surface : placement->surfaces()) add(surface);
  first_sleeper_ = touched_.size();
  if (sleepers && sleepers->placed())
    for (Surface& sleeper : sleepers->surfaces()) add(sleeper);
  if (platen) platen_number_ = add(platen->surface());
  first_tine_ = touched_.size();
  if (tines)
    for (Surface& side : tines->surfaces()) add(side);
  particles.set_surfaces(surfaces);
  set_means(kept);
  share_out();
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

// `place` also resets the servo, which is not used while the platen is lifted.
void World::lift_platen(double before, double motion) {
  platen->place(platen->z() + before);
  for (Vec3& node : platen->surface().motion) node = Vec3(0, 0, motion);
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
  const dem::SurfaceAction& did = particles.surface_action();
  coupler.collect(1, instant, {did.force, did.moment, did.work});
  placement->begin(particles, on_placed());
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

// Spans into the coupler: valid until the next registration of surfaces.
std::vector<std::span<const Vec3>> World::on_sleepers() const {
  std::vector<std::span<const Vec3>> forces;
  for (std::size_t i = 0; i < sleepers->count(); ++i)
    forces.push_back(coupler.mean_force(touched_[first_sleeper_ + i].number));
  return forces;
}

std::array<std::span<const Vec3>, 2> World::on_tines() const {
  return {coupler.mean_force(touched_[first_tine_].number),
          coupler.mean_force(touched_[first_tine_ + 1].number)};
}

// The ground is registered first.
std::span<const Vec3> World::on_ground() const { return coupler.mean_force(0); }

// Summed in the order of nodes: bitwise identical on every rank.
double World::on_platen() const {
  double force = 0;
  for (const Vec3& node : coupler.mean_force(platen_number_)) force += node.z();
  return force;
}

// As of the platen. By name, since numbers change with stages.
Vec3 World::on(const std::string& surface) const {
  Vec3 force = Vec3::Zero();
  for (const Touched& touched : touched_)
    if (touched.surface->name == surface)
      for (const Vec3& node : coupler.mean_force(touched.number)) force += node;
  return force;
}

std::vector<Vec3> World::on_placed() const {
  std::vector<Vec3> forces;
  for (const Touched& touched : touched_) {  // plates and boxes alone
    forces.emplace_back(Vec3::Zero());
    for (const Vec3& node : coupler.mean_force(touched.number)) forces.back() += node;
  }
  return forces;
}

observe::Scene World::scene() {
  return {.particles = particles,
          .ground = ground ? &*ground : nullptr,
          .sleepers = sleepers && sleepers->placed() ? &*sleepers : nullptr,
          .bodies = solids && solids->placed() ? &solids->bodies() : nullptr,
          .stones = model.has_stones()};
}

std::vector<observe::WallState> World::wall_states() const {
  std::vector<observe::WallState> states;
  for (const std::string& name : walls.names())
    states.push_back({name, on(name), walls.displacement(name)});
  if (model.has_stage(StageKind::tamp))
    for (const std::string& name : bed::Tines::names())
      states.push_back({name, on(name), tines ? tines->displacement(name) : Vec3::Zero()});
  return states;
}

observe::PlatenState World::platen_state() const {
  if (!platen) return {};
  return {.z = platen->z(), .pressure = platen->pressure(), .force = on("platen")};
}

std::size_t World::memory() const {
  return particles.memory().total() + (ground ? ground->memory() : 0) +
         (solids ? solids->bodies().memory() : 0);
}

// Only the owner of a node has its mean, all others add zero: the sum is exact.
std::vector<World::Means> World::means() const {
  std::vector<Means> all;
  for (const Touched& touched : touched_) {
    Means means{touched.surface->name, coupler.save_mean(touched.number)};
    comm.sum(std::span<double>(means.force.empty() ? nullptr : means.force[0].data(),
                               3 * means.force.size()));
    all.push_back(std::move(means));
  }
  return all;
}

// A new surface, or one with another number of nodes, begins without load.
void World::set_means(const std::vector<Means>& means) {
  for (const Touched& touched : touched_)
    for (const Means& kept : means)
      if (kept.surface == touched.surface->name && kept.force.size() == touched.surface->nodes())
        coupler.load_mean(touched.number, kept.force);
}

}  // namespace trackbed::model
