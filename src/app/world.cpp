// Surfaces come and go with stages: floor and walls with the fill, the platen for a while, sleepers
// for good. Each time `meet` tells stones and coupler anew. Rejected: surfaces that exist from the
// start and are switched off; every room would have to know the switch.
#include "app/world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "trackbed/core/error.hpp"

namespace trackbed::app {

// The ground and the sleepers exist from the start, because their sizes are columns of the
// histories; sleepers take part once they are placed.
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
    watched = observe::watched_nodes(*ground, model.dimension);
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

// Whatever changes surfaces ends here, so that stones, coupler and numbers never disagree. Costs a
// new split of the stones and a new connection of the coupler, so it is for stages, not for
// windows.
void World::meet() {
  // By name, since numbers change: the ground goes on under the load it had, and a new surface
  // begins without one.
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

// Whose stones are where decides which nodes a rank needs: coupler after stones.
void World::connect() {
  coupler.connect([&](const Vec3& low, const Vec3& high) { return particles.reaches(low, high); });
}

// At rest, its lower face at height z, m.
void World::place_platen(double z) {
  platen.emplace(model.platen, model.container(), model.material(model.wall_material));
  platen->place(z);
  meet();
}

// `place` also puts the servo to rest, whose forces mean nothing while the plate goes up.
void World::lift_platen(double before, double motion) {
  platen->place(platen->z() + before);
  for (Vec3& node : platen->surface().motion) node = Vec3(0, 0, motion);
}

void World::take_platen_away() {
  platen.reset();
  meet();
}

bed::Tines World::make_tines() const {
  bed::TampedSleepers tamped{.width = model.sleepers.width};
  for (std::size_t i = 0; i < sleepers->count(); ++i) tamped.x.push_back(sleepers->x(i));
  return {model.tamping, tamped, model.dimension, model.domain().thickness,
          model.material(model.sleepers.material)};
}

// As deep as below the lowest sleeper. Tines of steel have the contacts of sleepers.
void World::place_tines() {
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < sleepers->count(); ++i)
    lowest = std::min(lowest, sleepers->bottom() + sleepers->state(i).displacement.z());
  tines.emplace(make_tines());
  tines->aim(top_of_stones(), lowest + model.tamping.lift);
  if (tines->tip() <= 0)
    throw RunError(fmt::format("the tines would go to z = {:.4g} m, through the floor of the bed",
                               tines->tip()));
  meet();
}

void World::take_tines_away() {
  tines.reset();
  meet();
}

// A window too short for anything to move, with surfaces at rest: stones that touch where they
// begin are kicked by those forces from the first sub-step on, and not from the second.
void World::place_stones() {
  constexpr double instant = 1e-30;  // s
  placement->place(particles);
  placement->show(0, 0);
  meet();
  coupler.publish();
  particles.advance(instant, 1);
  const dem::SurfaceAction& did = particles.surface_action();
  coupler.collect(1, instant, {did.force, did.moment, did.work});
  placement->begin(particles, on_placed());
}

// Minus infinity without stones. A hull of balls is as high as the highest of them.
double World::top_of_stones() const {
  double top = -std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < particles.size(); ++i)
    particles.corners(
        i, [&](const Vec3& centre, double radius) { top = std::max(top, centre.z() + radius); });
  return comm.max(top);
}

// Of the nodes' motion, so that it is exactly 0 on a ground that never moved.
// The sum over ranks depends on their number in its last bits: for figures only, no result goes
// back into the motion.
double World::mean_ground_level() const {
  if (!ground) return 0;
  double sum = 0;
  for (const std::int32_t own : ground->own_top()) sum += ground->top_state(own).displacement.z();
  return comm.sum(sum) / static_cast<double>(ground->top_owner().size());
}

// Spans into the coupler: valid until the next `meet`.
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

// `meet` adds the ground first.
std::span<const Vec3> World::on_ground() const { return coupler.mean_force(0); }

// Nodes in their order: the same bits on every rank.
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

// Every node's mean is known to its owner alone, all others add zero: the sum is exact.
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

// A surface that is new, or has another number of nodes, begins without load.
void World::set_means(const std::vector<Means>& means) {
  for (const Touched& touched : touched_)
    for (const Means& kept : means)
      if (kept.surface == touched.surface->name && kept.force.size() == touched.surface->nodes())
        coupler.load_mean(touched.number, kept.force);
}

}  // namespace trackbed::app
