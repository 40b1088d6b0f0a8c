// Bounds here are no physics of their own: beyond them no track can be meant, within them nothing
// is said. They are wide, since a warning that comes with sound runs is soon read no more.
#include "app/doubts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace trackbed::app {

namespace {

constexpr double bed_tolerance = 0.1;  // of the height: beds of one kind differ by 5 % (quickstart)
constexpr double far_sunk = 0.1;       // m: a third of a usual bed
constexpr double fast = 3;             // m/s: as after a fall of half a metre

// Own stones that are too fast or above the walls, which hold them at the ends of the bed.
std::int64_t flying(const World& world) {
  std::int64_t count = 0;
  for (std::size_t i = 0; i < world.particles.size(); ++i) {
    const dem::ParticleView stone = world.particles[i];
    const bool high = world.walls.height() > 0 && stone.position.z() > world.walls.height();
    if (high || stone.velocity.norm() > fast) ++count;
  }
  return count;
}

// The sleeper that went down most, from where it was placed; all ranks hold all sleepers.
std::string doubt_of_sleepers(const World& world) {
  if (!world.sleepers || !world.sleepers->placed()) return {};
  const track::Sleepers& sleepers = *world.sleepers;
  std::size_t worst = 0;
  const auto sunk = [&](std::size_t i) { return -sleepers.state(i).displacement.z(); };
  for (std::size_t i = 0; i < sleepers.count(); ++i)
    if (sunk(i) > sunk(worst)) worst = i;
  const double ballast = sleepers.bottom();  // m: the bed begins at z = 0
  if (!(sunk(worst) > std::min(far_sunk, ballast))) return {};
  return fmt::format(
      "the sleeper at x = {:g} m has gone down by {:.3g} mm since it was placed on {:.3g} mm of "
      "ballast: the bed does not carry it, and what was computed since is of little worth",
      sleepers.x(worst), 1e3 * sunk(worst), 1e3 * ballast);
}

// m^3 (plane: the slice's). For a sentence only: its last bits depend on the ranks.
double volume_of_stones(const World& world) {
  double volume = 0;
  for (std::size_t i = 0; i < world.particles.size(); ++i) volume += world.particles[i].volume;
  return world.comm.sum(volume);
}

// Of the layers that were poured, one on the other: heights add, and so do their solid parts.
struct Expected {
  double height = 0;  // m
  double porosity = 0;
};

Expected expected_of(const Model& model, std::span<const Stage> done) {
  double height = 0, solid = 0;
  for (const Stage& stage : done) {
    if (stage.kind != StageKind::fill) continue;
    const bed::BedParameters layer = model.bed.of_layer(stage.layer);
    height += layer.height;
    solid += layer.height * (1 - layer.porosity);
  }
  if (height <= 0) return {model.bed.height, model.bed.porosity};  // poured in another run
  return {height, 1 - solid / height};
}

}  // namespace

// With V the volume of all stones, m^3, A the area and z the height below the plate,
//   n = 1 - V/(A z),   asked: z = V/(A (1 - n_deck)).
// The platen and the ground touch single stones only: half a stone's width of the height may be
// voids that no bed has in its middle.
std::string doubt_of_bed(const World& world, std::span<const Stage> done) {
  const Model& model = world.model;
  const double level = world.mean_ground_level();
  const double volume = volume_of_stones(world);
  if (!world.platen || volume <= 0) return {};
  const double area = world.walls.area();  // m^2
  const double height = world.platen->z() - level;
  const Expected expected = expected_of(model, done);
  const double asked = volume / (area * (1 - expected.porosity));
  const double voids_at_faces = 0.5e-3 * model.bed.sieve.back();  // m, sieves are in mm
  if (height >= (1 - bed_tolerance) * asked &&
      height <= (1 + bed_tolerance) * asked + voids_at_faces)
    return {};
  return fmt::format(
      "the pressed bed is {:.3g} m high with a porosity of {:.2f}; bed.porosity = {:.3g} would "
      "make it {:.3g} m (bed.height = {:g} m)",
      height, 1 - volume / (area * height), expected.porosity, asked, expected.height);
}

// While stones fall from above, as in fill and cribs, they are fast and that is meant.
std::vector<std::string> doubts_of_end(const World& world, StageKind last) {
  std::vector<std::string> doubts;
  if (const std::string doubt = doubt_of_sleepers(world); !doubt.empty()) doubts.push_back(doubt);
  const std::int64_t stones = world.comm.sum(flying(world));
  if (stones > 0 && world.model.has_bed() && last != StageKind::fill && last != StageKind::cribs)
    doubts.push_back(fmt::format("{} stone{} at the end: faster than {:g} m/s or above the walls",
                                 stones, stones > 1 ? "s fly" : " flies", fast));
  // A few are those of a violent fill; they cost a hundred times a contact's work.
  const std::int64_t deep = world.particles.core_overlaps();
  if (deep > world.particles.totals().particles)
    doubts.push_back(
        fmt::format("stones had their cores in one another {} times (pairs, each sub-step "
                    "counted): give larger "
                    "roundings (bed.polyhedron.rounding), stiffer contacts or less violent stages",
                    deep));
  return doubts;
}

}  // namespace trackbed::app
