// The kinds of stages. What a stage does in a window follows from the deck, the clock, the model,
// and what is counted of cycles, jumps and trains.
//
// Kinds differ in few points, which are distinguished by `if`. Rejected: a class per kind, which
// would spread begin, watch and end over many files with mostly empty functions.
#include "model/stages/stages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/scene/cell.hpp"
#include "model/stages/cribs.hpp"
#include "model/stages/shear.hpp"

namespace trackbed::model {

namespace {

// Height of the walls over that of growing stones: they are still loose, and their surface is
// uneven.
constexpr double grown_height = 2;

// Interval of the check for rest, which costs a sum over all contacts.
constexpr std::int64_t windows_between_checks = 250;

// Load of the load stage over its peak, 0 to 1: ramp, hold, ramp; or cycles of (1 - cos)/2, a
// haversine, which is usual in laboratory tests. A cycle begins and ends at zero with zero slope; a
// ramp takes at most half the stage.
double load_shape(const Stage& stage, double time) {
  if (stage.cycles > 0) {
    const double cycles = static_cast<double>(stage.cycles) * time / stage.duration;
    return 0.5 * (1 - std::cos(2 * std::numbers::pi * cycles));
  }
  const double ramp = std::min(stage.ramp, stage.duration / 2);
  if (ramp <= 0) return 1;
  return std::clamp(std::min(time, stage.duration - time) / ramp, 0.0, 1.0);
}

bool has_cycles(const Stage& stage) {
  const bool loaded = stage.kind == StageKind::load || stage.kind == StageKind::passage;
  return loaded && stage.cycles > 0;
}

// Not under load: the criterion would end a stage between axles or cycles.
bool ends_at_rest(const Stage& stage) {
  const bool loaded = stage.kind == StageKind::load || stage.kind == StageKind::passage ||
                      stage.kind == StageKind::jump || stage.kind == StageKind::shear ||
                      stage.kind == StageKind::triaxial;
  return stage.until_ratio > 0 && !loaded;
}

// Stones are at rest if forces are balanced and there are at least as many contacts as stones. The
// latter excludes stones in free fall (no forces at all): a pile in equilibrium has on average more
// than two contacts per stone, shared by two stones each, and a single stone lies on something.
bool at_rest(const dem::Totals& totals, double ratio) {
  return totals.contacts >= totals.particles && totals.unbalanced < ratio;
}

}  // namespace

StageActions::StageActions(World& world, const Model& model)
    : world_(world),
      model_(model),
      seat_load_(model.load, model.sleepers.spacing,
                 static_cast<std::size_t>(std::max<std::int64_t>(model.sleepers.count, 0))),
      jump_(world, model),
      train_(world, model) {}

// Collective. Order: damping, friction and stiffness, then bodies that are removed, bodies that are
// added, the registration of surfaces, which connects the ground's top to the ranks that need it,
// and finally bonds between the stones that are left.
std::string StageActions::begin(const Stage& stage) {
  set_contacts(stage);
  const bool has_platen = has_platen_load(stage.kind) || stage.kind == StageKind::release;
  if (!has_platen && world_.platen) world_.take_platen_away();
  if (world_.placement && &stage == &model_.stages.front()) world_.place_stones();
  if (stage.kind == StageKind::fill) pour(stage);
  if (stage.kind == StageKind::sleepers) place_sleepers(stage);
  if (stage.profile > 0 && stage.kind != StageKind::cribs) cut_to_profile(world_, stage.profile);
  if (stage.kind == StageKind::cribs) fill_cribs(stage);
  if (stage.kind == StageKind::tamp) world_.place_tines();
  const auto number = static_cast<std::size_t>(&stage - model_.stages.data());
  // Also without breakage: a checkpoint may come from a run with it.
  world_.particles.let_break(model_.breakage.any() && number >= model_.breaks_from());
  if (has_cycles(stage)) settlement_.begin(*world_.sleepers);
  if (stage.kind == StageKind::compact && !world_.platen)
    world_.place_platen(world_.top_of_stones());  // registers surfaces
  else
    world_.register_surfaces();
  make_bonds(world_, stage);
  if (has_platen && world_.platen)
    world_.platen->set_target(model_.pressure_in(stage), stage.kind == StageKind::shear);
  world_.walls.retarget();
  return jump_.begin(stage);
}

void StageActions::set_contacts(const Stage& stage) {
  world_.particles.set_local_damping(stage.local_damping);
  world_.particles.set_friction(stage.friction);
  world_.particles.set_stiffness(stage.stiffness);
  if (stage.kind == StageKind::jump) world_.particles.scale_friction(jump_.friction());
}

// A second layer falls onto the existing stones.
void StageActions::pour(const Stage& stage) {
  const bed::BedParameters layer = model_.bed.of_layer(stage.layer);
  const double below = std::max(0.0, world_.top_of_stones());  // minus infinity without stones
  const int material = model_.material(layer.material);
  if (stage.growth > 0) {
    const double top = bed::fill_to_grow(world_.particles, world_.comm, layer, material, below,
                                         stage.growth_height);
    world_.walls.build(below + grown_height * (top - below));
    return;
  }
  const double height = model_.bed.cell.empty()
                            ? bed::fill(world_.particles, world_.comm, layer, material, below)
                            : lay_cells(world_);
  // A tenth above the lattice, for stones that rebound.
  world_.walls.build(1.1 * height);
}

// Sleepers are placed at their final position, and stones that overlap them are removed, not
// displaced.
void StageActions::place_sleepers(const Stage& stage) {
  world_.sleepers->place(stage.height > 0 ? stage.height : world_.top_of_stones());
  dig_out_sleepers(world_);
}

// More stones than fit, since loose stones need more volume than given by the porosity: `end` cuts
// the heaps. Stones fall from above all existing stones and sleepers, so that none overlap
// initially.
void StageActions::fill_cribs(const Stage& stage) {
  // Present positions and not those at the start of the last window, which a run that starts from a
  // checkpoint does not have.
  world_.sleepers->show_at_rest();
  const double height = bed::fill_boxes(world_.particles, world_.comm, model_.bed,
                                        model_.material(model_.bed.material),
                                        cribs(world_, stage.profile), world_.top_of_stones());
  if (1.1 * height > world_.walls.height()) world_.walls.build(1.1 * height);
}

// Growth is fast at first, while stones have space, and ends with zero rate, so that stones in
// contact come to rest. With g the size over the final one and T the time of growth,
//   1 - g = (1 - g0)(1 - t/T)^2,
// from one window to the next, so that a resumed run needs only the present g.
void StageActions::grow(const Stage& stage, double time, double dt) {
  const double grown = world_.particles.grown();
  if (stage.growth <= 0 || grown >= 1) return;
  const double left = 1 - time / stage.growth, then = std::max(0.0, left - dt / stage.growth);
  const double ratio = left > 0 ? then / left : 0;
  world_.particles.grow_to(1 - (1 - grown) * ratio * ratio);
}

// Heights are read when a cycle ends: the other windows have no cost.
void StageActions::watch(const Stage& stage, const Clock& clock) {
  if (has_cycles(stage) && settlement_.watch(stage.cycles, clock, *world_.sleepers))
    jump_.end_cycle(stage);
  jump_.watch(stage, clock);
  clear_beside_floor(world_, clock);
}

// Known before the stage begins: a passage depends only on the axles and the last sleeper.
double StageActions::duration(const Stage& stage) const {
  if (stage.kind == StageKind::tamp)
    return model_.tamping.cycle() * static_cast<double>(std::max<std::int64_t>(stage.cycles, 1));
  if (stage.kind != StageKind::passage || stage.duration > 0) return stage.duration;
  const auto& s = model_.sleepers;
  const double once =
      stage.train ? train_.duration()
                  : seat_load_.duration(s.first + s.spacing * static_cast<double>(s.count - 1));
  return once * static_cast<double>(std::max<std::int64_t>(stage.cycles, 1));
}

void StageActions::send_train(const Stage& stage, double window) {
  if (stage.train) train_.send(window, stage.rail, stage.ramp);
}

void StageActions::move_train(const Stage& stage, const Clock& clock) {
  train_.move(std::max<std::int64_t>(stage.cycles, 1), clock);
}

// The trains of a passage are equal: time starts again with each.
double StageActions::time_of_train(const Stage& stage, double time) const {
  if (stage.kind != StageKind::passage || stage.cycles < 2) return time;
  return std::fmod(time, duration(stage) / static_cast<double>(stage.cycles));
}

// A wheel that starts on the rails, which carry it from one element before their ends, takes up its
// load in the ramp, smoothly; so do those of each later train.
std::vector<track::AxleLoad> StageActions::axles(const Stage& stage, double time) const {
  if (stage.kind != StageKind::passage || !model_.has_solid_rails()) return {};
  time = time_of_train(stage, time);
  std::vector<track::AxleLoad> loads = seat_load_.axles(time);
  const double trains = static_cast<double>(std::max<std::int64_t>(stage.cycles, 1));
  const double ramp = std::min(stage.ramp, duration(stage) / trains / 2);
  if (time >= ramp) return loads;
  const std::vector<track::AxleLoad> before = seat_load_.axles(0);
  const double begin = model_.sleepers.first - model_.sleepers.spacing / 2 - model_.solid.element;
  for (std::size_t k = 0; k < loads.size(); ++k)
    if (before[k].x > begin)
      loads[k].force *= (1 - std::cos(std::numbers::pi * std::max(time, 0.0) / ramp)) / 2;
  return loads;
}

// With a train: the present forces of its pads, independent of `time`. Otherwise the constant force
// plus the load of the stage's kind; axles on solid rails add nothing here. The present x of the
// sleepers is used and not that of the deck.
std::vector<double> StageActions::seat_forces(const Stage& stage, double time) const {
  time = time_of_train(stage, time);
  std::vector<double> forces(world_.sleepers ? world_.sleepers->count() : 0, stage.seat_force);
  for (std::size_t i = 0; i < forces.size(); ++i) {
    if (stage.kind == StageKind::load) forces[i] += stage.load * load_shape(stage, time);
    forces[i] += jump_.load(stage, time);
    if (train_.there())
      forces[i] += train_.seat_force(i);
    else if (stage.kind == StageKind::passage && !model_.has_solid_rails())
      forces[i] += seat_load_.at(world_.sleepers->x(i), time, i);
  }
  return forces;
}

// Loads other than those of a train or of a table for both seats are distributed equally to them.
std::vector<double> StageActions::on_seats(const Stage& stage, double time,
                                           const std::vector<double>& sums) const {
  if (train_.there() || model_.load.gauge == 0) return train_.on_seats(sums);
  const bool passes = stage.kind == StageKind::passage;
  std::vector<double> all;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double more = passes ? seat_load_.left_excess(time_of_train(stage, time), i) : 0;
    all.insert(all.end(), {sums[i] / 2 + more, sums[i] / 2 - more});
  }
  return all;
}

bool StageActions::walls_are_steady(const Stage& stage) const {
  return stage.confinement <= 0 || world_.walls.steady_for() >= model_.platen.hold;
}

// In order: pressures reached, settlement small enough, stones at rest. The last is checked at
// windows counted from the start of the stage, so that a resumed run checks the same ones.
bool StageActions::settled(const Stage& stage, const Clock& clock) const {
  if (stage.kind == StageKind::compact && world_.platen->steady() && walls_are_steady(stage))
    return true;
  if (stage.settlement > 0 && settlement_.last() >= 0 && settlement_.last() <= stage.settlement)
    return true;
  if (jump_.is_over(stage, clock)) return true;
  if (!ends_at_rest(stage) || clock.window() == 0 || world_.particles.grown() < 1) return false;
  if (clock.window() % windows_between_checks != 0) return false;
  return at_rest(world_.particles.totals(), stage.until_ratio);
}

// What the platen bears when it is removed at the end of a release is set free at once and throws
// the bed up. No value if this is little: a release has no aim. The force is that of the last
// window because the averaged pressure would lag behind in a short stage.
std::optional<std::string> StageActions::load_left(const Stage& stage) const {
  if (stage.kind != StageKind::release || !world_.platen) return std::nullopt;
  constexpr double little = 0.05;  // of the target of the platen before
  const Stage* loaded = &stage;
  while (loaded != &model_.stages.front() && !has_platen_load(loaded->kind)) --loaded;
  const double before = model_.pressure_in(*loaded);
  const double left = world_.force_on({SurfaceId::Part::platen}).z() / world_.walls.area();
  if (left <= little * before) return std::nullopt;
  return fmt::format(
      "the platen bears {:.1f} kPa when it is removed; required: at most {:g} % of its target of "
      "{:g} kPa, or the bed rebounds at once and becomes loose; give a longer stage.duration{} or "
      "a larger stage.lift",
      left / 1e3, 100 * little, before / 1e3,
      stage.until_ratio > 0 ? ", no stage.until_ratio" : "");
}

// Three results: no value (the kind has no aim), an empty sentence (reached), the deviation.
std::optional<std::string> StageActions::shortfall(const Stage& stage) const {
  if (stage.kind == StageKind::compact) {
    if (!world_.platen->steady() || walls_are_steady(stage)) return world_.platen->shortfall();
    return fmt::format(
        "the pressure of the walls was within {:g} % of {:g} kPa only for {:.3g} s instead of {:g} "
        "s (platen.hold); give a longer stage.duration",
        100 * model_.platen.tolerance, stage.confinement / 1e3, world_.walls.steady_for(),
        model_.platen.hold);
  }
  if (stage.kind == StageKind::jump) return jump_.shortfall();
  if (auto left = load_left(stage)) return left;
  if (has_cycles(stage) && stage.settlement > 0) {
    if (settlement_.last() >= 0 && settlement_.last() <= stage.settlement) return std::string{};
    return fmt::format(
        "the largest settlement of a sleeper in the last cycle is {:.3g} mm; required: at most "
        "{:g} mm (stage.settlement); give more cycles{}",
        1e3 * settlement_.last(), 1e3 * stage.settlement,
        stage.kind == StageKind::load ? " in a longer stage.duration, or load with less "
                                        "stage.friction"
                                      : "");
  }
  // Without an aim of the deck; less is usual of a bed that carries a train.
  constexpr double much = 0.5e-3;  // m
  if (stage.kind == StageKind::load && settlement_.last() > much && stage.cycles > 1)
    return fmt::format(
        "the largest settlement of a sleeper in the last cycle is {:.3g} mm: the bed still settles "
        "under this load (more than {:g} mm); give more cycles in a longer stage.duration, or "
        "state what is required by stage.settlement",
        1e3 * settlement_.last(), 1e3 * much);
  if (!ends_at_rest(stage)) return std::nullopt;
  const dem::Totals totals = world_.particles.totals();
  if (at_rest(totals, stage.until_ratio)) return std::string{};
  if (totals.unbalanced < stage.until_ratio)
    return fmt::format(
        "there are {} contacts of {} stones; at rest there are at least as many contacts as "
        "stones; give a longer stage.duration",
        totals.contacts, totals.particles);
  return fmt::format(
      "the mean net force divided by the mean contact force is {:.3g}; required: below {:g} "
      "(stage.until_ratio); give a longer stage.duration or a larger stage.local_damping",
      totals.unbalanced, stage.until_ratio);
}

// After stages of kind fill and settle stones are stopped, so that the next stage begins with zero
// velocities. Damping and friction below 0: those of the materials and contact laws again.
void StageActions::end(const Stage& stage) {
  if (stage.kind == StageKind::release && world_.platen) world_.take_platen_away();
  if (stage.kind == StageKind::fill || stage.kind == StageKind::settle) world_.particles.stop();
  if (stage.kind == StageKind::cribs) {
    cut_to_profile(world_, stage.profile);
    world_.register_surfaces();
  }
  if (stage.kind == StageKind::lift_walls) {
    world_.walls.remove();
    world_.register_surfaces();
  }
  if (stage.kind == StageKind::tamp) world_.take_tines_away();
  settlement_.end();
  jump_.end(stage);
  train_.take_away();
  world_.particles.set_local_damping(-1);
  world_.particles.set_friction(-1);
}

void StageActions::archive(io::Archive& a, double window) {
  if (a.has("run/settlement", settlement_.begun())) {
    if (a.reads()) settlement_.begin(*world_.sleepers);
    a.part("run/settlement", settlement_);
  }
  train_.archive(a, window);
  if (a.has("run/jump", jump_.counts())) a.part("run/jump", jump_);
}

}  // namespace trackbed::model
