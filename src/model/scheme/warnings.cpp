// The bounds are not part of the model: results beyond them are not those of a usual track. They
// are wide, since warnings of correct runs would soon be ignored.
#include "model/scheme/warnings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace trackbed::model {

namespace {

constexpr double bed_tolerance = 0.1;  // of the height: beds of one kind differ by 5 %
constexpr double far_sunk = 0.1;       // m: a third of the height of a usual bed
constexpr double fast = 3;             // m/s: as after a fall of half a metre

// Number of own stones that are too fast, or above the walls at the ends of the bed.
std::int64_t flying(const World& world) {
  std::int64_t count = 0;
  for (std::size_t i = 0; i < world.particles.size(); ++i) {
    const dem::ParticleView stone = world.particles[i];
    const bool high = world.walls.height() > 0 && stone.position.z() > world.walls.height();
    if (high || stone.velocity.norm() > fast) ++count;
  }
  return count;
}

// The sleeper with the largest settlement since it was placed; all ranks have all sleepers.
std::string warning_of_sleepers(const World& world) {
  if (!world.sleepers || !world.sleepers->placed()) return {};
  const track::Sleepers& sleepers = *world.sleepers;
  std::size_t worst = 0;
  const auto sunk = [&](std::size_t i) { return -sleepers.state(i).displacement.z(); };
  for (std::size_t i = 0; i < sleepers.count(); ++i)
    if (sunk(i) > sunk(worst)) worst = i;
  const double ballast = sleepers.bottom();  // m: the bed begins at z = 0
  const double limit = std::min(far_sunk, ballast);
  if (!(sunk(worst) > limit)) return {};
  return fmt::format(
      "the sleeper at x = {:g} m has settled by {:.3g} mm (limit {:.3g} mm) since it was placed on "
      "{:.3g} mm of ballast: the ballast below this sleeper has failed or the ground has sunk; "
      "results since this happened are not reliable; check loads, compaction and the stiffness of "
      "the ground",
      sleepers.x(worst), 1e3 * sunk(worst), 1e3 * limit, 1e3 * ballast);
}

// m^3 (plane: over the thickness). For messages only: its last bits depend on the ranks.
double volume_of_stones(const World& world) {
  double volume = 0;
  for (std::size_t i = 0; i < world.particles.size(); ++i) volume += world.particles[i].volume;
  return world.comm.sum(volume);
}

// Of the poured layers, one above the other: heights add, and so do their solid volumes.
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

// With V the volume of all stones, m^3, A the area and z the height below the platen,
//   n = 1 - V/(A z),   expected: z = V/(A (1 - n_deck)).
// Platen and ground touch only single stones: half a stone's width of the height may be additional
// voids at these faces.
std::string warning_of_bed(const World& world, std::span<const Stage> done) {
  const Model& model = world.model;
  const double level = world.mean_ground_level();
  const double volume = volume_of_stones(world);
  if (!world.platen || volume <= 0) return {};
  const double area = world.walls.area();  // m^2
  const double height = world.platen->z() - level;
  const Expected expected = expected_of(model, done);
  const double expected_height = volume / (area * (1 - expected.porosity));
  const double voids_at_faces = 0.5e-3 * model.bed.sieve.back();  // m, sieves are in mm
  const double least = (1 - bed_tolerance) * expected_height;
  const double most = (1 + bed_tolerance) * expected_height + voids_at_faces;
  if (height >= least && height <= most) return {};
  return fmt::format(
      "the compacted bed has a height of {:.3g} m and a porosity of {:.2f}; with the porosity of "
      "the deck, {:.3g}, the same stones would form a bed {:.3g} m high; heights of the bed of "
      "{:.3g} to {:.3g} m are accepted (bed.height: {:g} m); check the stages, or change "
      "bed.porosity",
      height, 1 - volume / (area * height), expected.porosity, expected_height, least, most,
      expected.height);
}

// In stages of kind fill and cribs falling stones are expected to be fast.
std::vector<std::string> warnings_of_end(const World& world, StageKind last) {
  std::vector<std::string> warnings;
  if (const std::string warning = warning_of_sleepers(world); !warning.empty())
    warnings.push_back(warning);
  const std::int64_t stones = world.comm.sum(flying(world));
  if (stones > 0 && world.model.has_bed() && last != StageKind::fill && last != StageKind::cribs)
    warnings.push_back(
        fmt::format("{} stone{} faster than {:g} m/s or above the walls at the end: the bed may "
                    "not be at rest, or may have lost stones; check the last stages",
                    stones, stones > 1 ? "s are" : " is", fast));
  // A few occur in fills with high speeds; each costs about a hundred contacts.
  const std::int64_t deep = world.particles.core_overlaps();
  if (deep > world.particles.totals().particles)
    warnings.push_back(fmt::format(
        "overlaps larger than the sum of both rounding radii occurred {} times (a pair is counted "
        "again in every sub-step; limit: the number of stones, {}); increase the rounding radius "
        "of the stones "
        "(bed.polyhedron.rounding, stone.rounding, or --rounding of their library), use stiffer "
        "contacts, or reduce speeds",
        deep, world.particles.totals().particles));
  return warnings;
}

std::string warning_of_steps(const Model& model, std::span<const StageRecord> done) {
  std::vector<std::string> stages;
  double least = std::numeric_limits<double>::infinity();  // s
  for (const StageRecord& stage : done) {
    if (stage.stable_step == 0 || stage.stable_step >= stage.step()) continue;
    stages.push_back(
        fmt::format("{} ({:.2f} times)", stage.name, stage.step() / stage.stable_step));
    least = std::min(least, stage.stable_step);
  }
  if (stages.empty()) return {};
  const std::string safety =
      model.time.step > 0 ? ""
                          : fmt::format(", or a smaller dem.safety than {:g}", model.dem.safety);
  return fmt::format(
      "sub-steps are longer than the contacts at the end of these stages allow: {}; forces of some "
      "stones can alternate there from sub-step to sub-step: give time.step of at most {:.3g} s{}",
      fmt::join(stages, ", "), least, safety);
}

// The height to which the energy would lift the bed if nothing dissipated it.
std::string warning_of_stiffening(const World& world, const Stage& stage, const Stage& next) {
  constexpr double noticeable = 1e-3;  // m, a fiftieth of a stone
  if (!(next.stiffness > stage.stiffness)) return {};
  const double stiffer = next.stiffness / stage.stiffness;
  const dem::Totals totals = world.particles.totals();
  const double energy = stiffer * totals.elastic, weight = totals.mass * world.model.dem.gravity;
  if (!(weight > 0) || !(energy > noticeable * weight)) return {};
  return fmt::format(
      "stage {}: contacts become {:.3g} times as stiff at its end while they overlap, and their "
      "energy, then {:.3g} J, can lift all stones by {:.2g} mm (limit {:g} mm): stones are "
      "launched upwards; give it a larger stiffness or a longer duration",
      stage.name, stiffer, energy, 1e3 * energy / weight, 1e3 * noticeable);
}

std::vector<std::string> warnings_of_bonds(const World& world, std::size_t stage) {
  std::vector<std::string> warnings;
  for (std::size_t kind = 0; kind < world.model.bonds.size(); ++kind) {
    const dem::BondParameters& bond = world.model.bonds[kind];
    const std::size_t from = world.model.bonds_from(kind);
    const auto& broken = world.particles.bond_breaks();
    const std::int64_t ever =
        world.particles.bonds_of(kind) +
        world.comm.sum(std::count_if(broken.begin(), broken.end(), [&](const dem::BondBreak& each) {
          return each.kind == static_cast<int>(kind);
        }));
    if (bond.present && from < stage && ever == 0)
      warnings.push_back(fmt::format(
          "bond[{}] (\"{}\"): there are none, and this run begins after the stage \"{}\" in which "
          "they are made; name a later stage (bond.from)",
          kind, bond.name, world.model.stages[from].name));
  }
  return warnings;
}

}  // namespace trackbed::model
