// Shear boxes, lifted walls, walls that hold a pressure, pressures in steps.
//
// The way of the lower half, as that of the platen between walls that hold a pressure, begins with
// zero speed and slope, since a jump of speed sends a wave
// through the stones that the walls feel as force. It follows from the clock alone, so a resumed
// run needs no other state than where the walls are.
#include "app/shear.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace trackbed::app {

namespace {

// s: a stone that leaves the floor at 5 m/s goes 50 mm meanwhile, of the 250 mm to the end of the
// domain. Each look costs a sum over ranks, each stone found a new split.
constexpr double between_looks = 0.01;

// m, after `time` s, with r the time to full speed v = D/(T - r/2),
//   x = v/2 (t - r/pi sin(pi t/r)) for t < r,   v (t - r/2) after.
double way(const Stage& stage, double time) {
  const double r = std::min(stage.ramp, stage.duration / 2), t = std::min(time, stage.duration);
  const double v = stage.displacement / (stage.duration - r / 2);
  if (t >= r) return v * (t - r / 2);
  return v / 2 * (t - r / std::numbers::pi * std::sin(std::numbers::pi * t / r));
}

// Half the difference of what opposite walls feel, N, is what the stones between them push with.
void confine(World& world, double pressure, double dt) {
  const std::array push{(world.on("wall.right").x() - world.on("wall.left").x()) / 2,
                        (world.on("wall.back").y() - world.on("wall.front").y()) / 2};
  world.walls.confine(world.model.platen, dt, pressure, world.platen->z(), push);
}

// A jump of pressure shakes the bed: let go at once from 400 to 200 kPa, ballast went down by 0.1 %
// where it should rise.
double share_of_ramp(const Stage& stage, double time) {
  const double ramp = std::min(stage.ramp, stage.duration / 2);
  return ramp > 0 ? std::min(1.0, time / ramp) : 1;
}

}  // namespace

void move_walls(World& world, std::size_t number, double time, double dt) {
  const Stage& stage = world.model.stages[number];
  if (stage.confinement > 0 && world.platen) {
    // Walls that stood held whatever there was: they begin at once.
    const double before = number > 0 ? world.model.stages[number - 1].confinement : 0;
    const double from = before > 0 ? before : stage.confinement;
    const double share = share_of_ramp(stage, time);
    if (share < 1 && from != stage.confinement) world.walls.aim();  // not steady before it is there
    return confine(world, from + share * (stage.confinement - from), dt);
  }
  const bool shears = stage.kind == StageKind::shear, lifts = stage.kind == StageKind::lift_walls;
  world.walls.move(shears ? way(stage, time + dt) - way(stage, time) : 0,
                   lifts ? stage.lift * dt : 0);
}

void push_platen(World& world, const Stage& stage, double time, double dt) {
  world.platen->drive(dt, way(stage, time + dt) - way(stage, time), world.on_platen());
}

void tamp(World& world, double time, double dt) {
  world.tines->advance(time, dt, world.on_tines());
  world.sleepers->carry(dt, world.tines->lift(time + dt) - world.tines->lift(time),
                        world.on_sleepers());
}

// From the deck and the clock alone; until it is there the platen cannot be steady.
void aim_platen(World& world, std::size_t number, double time, double dt) {
  const std::vector<Stage>& stages = world.model.stages;
  const Stage& stage = stages[number];
  if (number == 0 || (stages[number - 1].kind != StageKind::compact &&
                      stages[number - 1].kind != StageKind::shear))
    return;
  const double from = world.model.pressure_in(stages[number - 1]);
  const double to = world.model.pressure_in(stage);
  if (from == to || share_of_ramp(stage, time - dt) >= 1) return;
  world.platen->aim(from + share_of_ramp(stage, time) * (to - from),
                    stage.kind == StageKind::shear);
}

// A box: the floor's own outline, also around a cylinder.
void clear_beside_floor(World& world, const Clock& clock) {
  if (world.model.bed.beside <= 0) return;
  const auto windows = std::max<std::int64_t>(1, std::llround(between_looks / clock.dt()));
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

}  // namespace trackbed::app
