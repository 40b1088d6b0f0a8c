// Shear boxes, lifted walls, walls with a controlled pressure, pressures in steps.
//
// The displacement of the lower half, and that of the platen in triaxial stages, begins with zero
// speed and acceleration, since a jump of speed sends a wave through the stones that acts on the
// walls. It follows from the clock alone, so that a resumed run needs only the positions of the
// walls.
#include "model/stages/shear.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "trackbed/core/whole_steps.hpp"

namespace trackbed::model {

namespace {

// s: a stone that leaves the floor at 5 m/s travels 50 mm in this time, of the 250 mm to the end of
// the domain. Each check costs a sum over ranks, each removal a new partition.
constexpr double between_checks = 0.01;

// Displacement, m, after `time` s, with r the time to full speed v = D/(T - r/2),
//   x = v/2 (t - r/pi sin(pi t/r)) for t < r,   v (t - r/2) after.
double driven_displacement(const Stage& stage, double time) {
  const double r = std::min(stage.ramp, stage.duration / 2), t = std::min(time, stage.duration);
  const double v = stage.displacement / (stage.duration - r / 2);
  if (t >= r) return v * (t - r / 2);
  return v / 2 * (t - r / std::numbers::pi * std::sin(std::numbers::pi * t / r));
}

// The servo controls the mean outward force, N, on each pair of opposite walls.
void confine(World& world, double pressure, double dt) {
  const auto on = [&](const char* wall) { return world.force_on(world.wall(wall)); };
  const std::array force{(on("wall.right").x() - on("wall.left").x()) / 2,
                         (on("wall.back").y() - on("wall.front").y()) / 2};
  world.walls.confine(world.model.platen, dt, pressure, world.platen->z(), force);
}

// Fraction of the ramp, 0 to 1. A jump of pressure excites the bed: unloaded at once from 400 to
// 200 kPa, ballast settled by 0.1 % where it should rise.
double ramp_fraction(const Stage& stage, double time) {
  const double ramp = std::min(stage.ramp, stage.duration / 2);
  return ramp > 0 ? std::min(1.0, time / ramp) : 1;
}

}  // namespace

void move_walls(World& world, std::size_t number, double time, double dt) {
  const Stage& stage = world.model.stages[number];
  if (stage.confinement > 0 && world.platen) {
    // Walls that were fixed had any pressure: the target then begins without a ramp.
    const double before = number > 0 ? world.model.stages[number - 1].confinement : 0;
    const double from = before > 0 ? before : stage.confinement;
    const double fraction = ramp_fraction(stage, time);
    if (fraction < 1 && from != stage.confinement)
      world.walls.retarget();  // not steady in the ramp
    return confine(world, from + fraction * (stage.confinement - from), dt);
  }
  const bool shears = stage.kind == StageKind::shear, lifts = stage.kind == StageKind::lift_walls;
  world.walls.move(
      shears ? driven_displacement(stage, time + dt) - driven_displacement(stage, time) : 0,
      lifts ? stage.lift * dt : 0);
}

void drive_platen(World& world, const Stage& stage, double time, double dt) {
  world.platen->drive(dt, driven_displacement(stage, time + dt) - driven_displacement(stage, time),
                      world.force_on({SurfaceId::Part::platen}).z());
}

void tamp(World& world, double time, double dt) {
  const auto on_tine = [&](std::size_t side) {
    return world.nodal_force_on({SurfaceId::Part::tine, side});
  };
  world.tines->advance(time, dt, {on_tine(0), on_tine(1)});
  world.sleepers->carry(dt, world.tines->lift(time + dt) - world.tines->lift(time),
                        world.nodal_forces_on(SurfaceId::Part::sleeper));
}

// The target follows from the deck and the clock alone; within the ramp the platen is not steady.
void aim_platen(World& world, std::size_t number, double time, double dt) {
  const std::vector<Stage>& stages = world.model.stages;
  const Stage& stage = stages[number];
  if (number == 0 || (stages[number - 1].kind != StageKind::compact &&
                      stages[number - 1].kind != StageKind::shear))
    return;
  const double from = world.model.pressure_in(stages[number - 1]);
  const double to = world.model.pressure_in(stage);
  if (from == to || ramp_fraction(stage, time - dt) >= 1) return;
  world.platen->set_target(from + ramp_fraction(stage, time) * (to - from),
                           stage.kind == StageKind::shear);
}

// The outline of the floor is a box, also around a cylinder.
void clear_beside_floor(World& world, const Clock& clock) {
  if (world.model.bed.beside <= 0) return;
  const auto windows = steps_within(between_checks, clock.dt());
  if (clock.window() % windows != 0) return;
  const bed::Container all = world.model.container();
  const auto off = [&](const dem::ParticleView& stone) {
    bool outside = false;
    for (int axis = 0; axis < (all.dimension == Dimension::plane ? 1 : 2); ++axis)
      outside = outside || (!all.periodic[static_cast<std::size_t>(axis)] &&
                            (stone.position[axis] < all.low[axis] - all.beside ||
                             stone.position[axis] > all.high[axis] + all.beside));
    return outside;
  };
  std::int64_t found = 0;
  for (std::size_t i = 0; i < world.particles.size(); ++i) found += off(world.particles[i]) ? 1 : 0;
  if (world.comm.sum(found) > 0) world.particles.remove(off);
}

}  // namespace trackbed::model
