// Rules that tie modules together: which stages need which, which materials exist and have a
// contact law, and whether bed, ground, sleepers and train are at positions where they act on each
// other. Impossible decks are errors; unusual ones give warnings.
//
// Each rule names the parameters it reads: it is evaluated only if all of them were read without a
// problem, so that one mistake gives one sentence. Bounds of a single parameter are given where it
// is declared.
#include "model/rules/rules.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "model/rules/skin_rule.hpp"
#include "trackbed/core/whole_steps.hpp"
#include "trackbed/dem/stiffness.hpp"

namespace trackbed::model {

namespace {

// A border given as 0.1 + 0.2 must equal one given as 0.3.

// The materials of all parts of the model exist, and those in contact have a law. Only existing
// parts count: a deck without ground need not give the material of its surface.
void declare_materials(const Model& model, input::Section& s) {
  std::vector<std::pair<std::string, std::string>> parts;  // key, name of the material
  const auto add = [&](std::string key, const std::string& name) {
    parts.emplace_back(std::move(key), name);
  };
  add("bed.material", model.bed.material);
  if (model.uses_walls()) add("wall_material", model.wall_material);
  add("ground_material", model.ground_material);
  if (model.uses_sleepers()) add("sleepers.material", model.sleepers.material);
  // A law between misspelt names would give a second sentence, on a missing law, about one mistake.
  const bool names_known = std::all_of(
      model.physics.laws.begin(), model.physics.laws.end(), [&](const dem::ContactLaw& law) {
        return model.material(law.first) >= 0 && model.material(law.second) >= 0;
      });
  std::set<std::string> stones = {model.bed.material};
  for (std::size_t i = 0; i < model.bed.layers.size(); ++i) {
    add(fmt::format("bed.layer[{}].material", i), model.bed.layers[i].material);
    stones.insert(model.bed.layers[i].material);
  }
  for (const auto& [key, name] : parts) {
    model.physics.rule_of_name(s, key, name);
    if (!names_known || model.material(name) < 0) continue;
    for (const std::string& stone : stones)
      s.rule(key, model.material(stone) < 0 || model.physics.has_law(stone, name),
             fmt::format("stones of \"{}\" touch \"{}\", but no [[contact]] gives a law for this "
                         "pair",
                         stone, name),
             {.reads = {"contact", "material", "bed", key}});
  }
  for (std::size_t m = 0; m < model.physics.materials.size(); ++m)
    s.rule(fmt::format("material[{}].name", m),
           std::any_of(
               parts.begin(), parts.end(),
               [&](const auto& part) { return part.second == model.physics.materials[m].name; }),
           "is the name of a material that no part of the model uses",
           {.severity = input::Severity::warning, .reads = {"material", "bed", "sleepers"}});
}

// True for ranges that are not pairs, which another rule reports.
bool is_within(const std::vector<double>& inner, const std::vector<double>& outer) {
  return inner.size() != 2 || outer.size() != 2 ||
         (inner[0] >= outer[0] - same_length && inner[1] <= outer[1] + same_length);
}

// Stones at the ends of a bed longer than its ground would fall, and the run would end with a lost
// stone minutes later.
void declare_ground_below(const Model& model, input::Section& s) {
  if (!model.ground.present || !model.ground.mesh.empty()) return;
  const auto below = [&](const std::string& axis, const auto& bed, const auto& ground) {
    s.rule("bed." + axis, is_within(bed, ground),
           fmt::format("reaches beyond ground.{} ({:g} to {:g} m): stones would fall beside the "
                       "ground; extend the ground or reduce the bed",
                       axis, ground[0], ground[1]),
           {.reads = {"ground.present", "ground." + axis, "bed." + axis}});
    if (!model.periodic_in(axis) || model.bed.sieve.empty() || bed.size() != 2) return;
    const double stone = 1e-3 * model.bed.sieve.back();  // mm
    s.rule(
        "ground." + axis, is_within({bed[0] - stone, bed[1] + stone}, ground),
        fmt::format("extends less than one stone size ({:g} m) past the periodic end of the bed: "
                    "stones that project past the end of the ground are not fully supported",
                    stone),
        {.severity = input::Severity::warning,
         .reads = {"ground.present", "ground." + axis, "bed", "periodic"}});
  };
  below("x", model.bed.x, model.ground.x);
  if (model.dimension == Dimension::space) below("y", model.bed.y, model.ground.y);
}

// A sleeper outside of the bed has no support and is an error; one that reaches beyond its end
// gives a warning, since half a sleeper at the end of a bed is a legitimate cut.
void declare_sleepers(const Model& model, input::Section& s) {
  const auto& p = model.sleepers;
  const auto& x = model.bed.x;
  if (!model.has_stage(StageKind::sleepers) || p.count < 1 || x.size() != 2) return;
  const double last = p.last();
  const std::string bed = fmt::format("the bed (bed.x: {:g} to {:g} m)", x[0], x[1]);
  const std::vector<std::string> reads = {
      "bed.x",      "bed.y",          "sleepers.count", "sleepers.first", "sleepers.spacing",
      "sleepers.y", "sleepers.width", "sleepers.length"};
  const auto outside = [&](double at) { return at < x[0] || at > x[1]; };
  const auto sticks_out = [&](double at) {
    return at - p.width / 2 < x[0] - same_length || at + p.width / 2 > x[1] + same_length;
  };
  s.rule("sleepers.first", !outside(p.first),
         fmt::format("puts the first sleeper outside {}; move it or make the bed longer", bed),
         {.reads = reads});
  s.rule("sleepers.count", outside(p.first) || !outside(last),
         fmt::format("puts the last sleeper at x = {:g} m, outside {}; give fewer sleepers, less "
                     "spacing or a longer bed",
                     last, bed),
         {.reads = reads});
  for (const auto& [key, at] : {std::pair{"sleepers.first", p.first}, {"sleepers.count", last}})
    s.rule(key, outside(at) || !sticks_out(at),
           fmt::format("the sleeper at x = {:g} m reaches beyond the end of {}", at, bed),
           {.severity = input::Severity::warning, .reads = reads});
  const auto& y = model.bed.y;
  if (model.dimension == Dimension::plane || y.size() != 2) return;
  const bool beside = p.y + p.length / 2 <= y[0] || p.y - p.length / 2 >= y[1];
  s.rule("sleepers.y", !beside,
         fmt::format("puts the sleepers beside the bed (bed.y: {:g} to {:g} m)", y[0], y[1]),
         {.reads = reads});
  s.rule(
      "sleepers.length", beside || is_within({p.y - p.length / 2, p.y + p.length / 2}, y),
      fmt::format("sleepers reach beyond the sides of the bed (bed.y: {:g} to {:g} m)", y[0], y[1]),
      {.severity = input::Severity::warning, .reads = reads});
}

// Positions of the axles of one train at the ends of its passage, relative to the sleepers. Axles
// move along +x: axle k is at start - behind_k + speed t. It loads a sleeper when it is above it.
struct AxlePassage {
  double first, last;   // m, x of sleepers
  double rear, lead;    // m behind the first axle: the largest and the smallest of all axles
  double time, travel;  // s, m, of one train
  bool any = false;     // whether an axle passes a sleeper
  std::string where;    // positions of the sleepers, for messages

  AxlePassage(const Model& model, const Stage& stage);
};

AxlePassage::AxlePassage(const Model& model, const Stage& stage)
    : first(model.sleepers.first), last(model.sleepers.last()) {
  const auto& load = model.load;
  rear = *std::max_element(load.axles.begin(), load.axles.end());
  lead = *std::min_element(load.axles.begin(), load.axles.end());
  const double trains = static_cast<double>(std::max<std::int64_t>(stage.cycles, 1));
  time = stage.duration > 0 ? stage.duration / trains
                            : track::SeatLoad(load, model.sleepers.spacing).duration(last);
  travel = load.speed * time;
  for (std::int64_t i = 0; i < model.sleepers.count; ++i)
    for (const double behind : load.axles) {
      const double on = first + static_cast<double>(i) * model.sleepers.spacing -
                        (load.start - behind);  // m, distance from the axle to the sleeper
      any = any || (on >= 0 && on <= travel);
    }
  where = fmt::format("sleepers are at x = {:g} to {:g} m", first, last);
}

// A passage in which no axle loads a sleeper would compute an unloaded bed for its whole duration.
void declare_load(const Model& model, const Stage& stage, const std::string& duration,
                  const input::About& about, input::Section& s) {
  const AxlePassage p(model, stage);
  const double start = model.load.start;
  // The parameter to report: for a start beyond the track more time is no remedy.
  const bool too_late = start - p.rear > p.last;
  s.rule(too_late ? "load.start" : duration, p.any,
         too_late ? fmt::format("no axle passes a sleeper: the last axle begins at x = {:g} m and "
                                "moves along +x ({}); start before the sleepers",
                                start - p.rear, p.where)
                  : fmt::format("no axle passes a sleeper: the first axle moves from x = {:g} to "
                                "{:g} m{} ({}); give more time, or 0 for the whole passage",
                                start - p.lead, start - p.lead + p.travel,
                                stage.cycles > 1 ? fmt::format(" in {:g} s, the duration divided "
                                                               "by the number of trains, {}",
                                                               p.time, stage.cycles)
                                                 : "",
                                p.where),
         about);
  if (!p.any) return;
  s.rule(duration, start - p.rear + p.travel >= p.last,
         fmt::format("ends before the last axle has passed the last sleeper ({})", p.where),
         {.severity = input::Severity::warning, .reads = about.reads});
}

// Solid rails extend half a spacing beyond the sleepers, and carry a wheel from one element before
// their ends.
void declare_wheels_on_rails(const Model& model, const Stage& stage, const AxlePassage& p,
                             const input::About& about, input::Section& s) {
  const double beyond = model.sleepers.spacing / 2 + model.solid.element;
  const double first = model.load.start - p.lead;
  s.rule("load.start", first < p.first - beyond || stage.ramp > 0,
         fmt::format("the first wheel, at x = {:g} m, acts on the rails suddenly, since it starts "
                     "on them; give stage.ramp, or start it before x = {:g} m, one element before "
                     "the rails",
                     first, p.first - beyond),
         {.severity = input::Severity::warning, .reads = about.reads});
}

// A load that begins with a jump excites oscillations of the bed.
void declare_begin(const Model& model, const Stage& stage, const input::About& about,
                   input::Section& s) {
  constexpr double negligible = 0.02;  // of the peak, as at the end of `duration`
  const AxlePassage p(model, stage);
  if (!p.any) return;
  const auto& load = model.load;
  if (model.solid.rails) return declare_wheels_on_rails(model, stage, p, about, s);
  const bool beyond = load.start - p.lead > p.first;
  s.rule("load.start", !beyond,
         fmt::format("the first axle starts at x = {:g} m, beyond the first sleeper, which is "
                     "therefore loaded suddenly; give a smaller load.start ({})",
                     load.start - p.lead, p.where),
         {.severity = input::Severity::warning, .reads = about.reads});
  const double at_first = track::SeatLoad(load, model.sleepers.spacing).at(p.first, 0);
  const double jump = load.peak_load() > 0 ? at_first / load.peak_load() : 0;
  s.rule(
      "load.start", beyond || std::abs(jump) <= negligible,
      fmt::format("the load of the first sleeper begins with a jump of {:.2g} times the peak; "
                  "start the first axle further away from the first sleeper (smaller load.start; "
                  "{})",
                  jump, p.where),
      {.severity = input::Severity::warning, .reads = about.reads});
}

// Missing sleepers are reported elsewhere; a table of loads has its own times and no axles. No
// axles are assumed: a user who forgets them would see the effect of a vehicle that he does not
// know.
void declare_passages(const Model& model, input::Section& s) {
  const auto& load = model.load;
  const bool acts = std::any_of(model.stages.begin(), model.stages.end(), [](const Stage& stage) {
    return stage.kind == StageKind::passage && !stage.train;
  });
  s.rule("load", acts || !input::differs_from_default(load),
         "has no effect: no stage of kind passage is without a train (train = false)",
         {.severity = input::Severity::warning, .reads = {"load", "stage"}});
  if (load.is_table() || model.sleepers.count < 1) return;
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    if (model.stages[i].kind != StageKind::passage || model.stages[i].train) continue;
    // With `start`, stages before the last one may be done.
    const bool may_be_done = !model.start.empty() && i + 1 < model.stages.size();
    s.rule("load.axles", !load.axles.empty() || may_be_done,
           fmt::format("must be given for the stage \"{}\" of kind passage: the distance of each "
                       "axle behind the first in m, for example [0, 2.8] for a bogie; or set train "
                       "= true for a vehicle on a rail",
                       model.stages[i].name),
           {.reads = {"load", "stage"}});
    if (load.axles.empty()) continue;
    const std::string duration = fmt::format("stage[{}].duration", i);
    const input::About about{
        .reads = {"load", "sleepers.count", "sleepers.first", "sleepers.spacing", duration}};
    declare_load(model, model.stages[i], duration, about, s);
    declare_begin(model, model.stages[i], about, s);
  }
}

// Valid parameters whose effect is most likely not intended.
void declare_oddities(const Model& model, input::Section& s) {
  const auto& ground = model.ground;
  const bool moves = std::any_of(model.stages.begin(), model.stages.end(),
                                 [](const Stage& stage) { return stage.ground_moves; });
  s.rule("ground.base_stiffness",
         !ground.present || !moves || ground.base != fem::Base::viscous ||
             ground.base_stiffness != 0 || !ground.base_motion.empty(),
         "a viscous base without springs carries no static load: under any load the ground "
         "sinks without end; give a spring stiffness above 0, or -1 for one chosen by the program, "
         "or base = "
         "\"fixed\"",
         {.severity = input::Severity::warning, .reads = {"ground", "stage"}});
  double held = 0;  // s until the ground moves, at most
  for (std::size_t i = 0; i < model.stages.size() && !model.stages[i].ground_moves; ++i)
    held += model.stages[i].duration;
  s.rule(
      "settle_average",
      !ground.present || !moves || !model.start.empty() || held == 0 ||
          3 * model.settle_average <= held,
      fmt::format("is a time constant of which at least three must pass before the ground moves, "
                  "which it does after {:g} s: the averaged load would not yet equal the load of "
                  "the bed; give less than {:.3g} s",
                  held, held / 3),
      {.severity = input::Severity::warning, .reads = {"settle_average", "ground", "stage"}});
  // Static loads of a stage are most likely meant to remain in the following stages.
  double before = 0;
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const Stage& stage = model.stages[i];
    const bool seated = stage.kind == StageKind::load || stage.kind == StageKind::passage;
    s.rule(fmt::format("stage[{}].seat_force", i), !seated || before == 0 || stage.seat_force != 0,
           fmt::format("the seat force of {:g} N of an earlier stage is removed in this stage; "
                       "give seat_force = {:g} to keep it",
                       before, before),
           {.severity = input::Severity::warning, .reads = {"stage"}});
    if (seated || stage.kind == StageKind::sleepers) before = stage.seat_force;
  }
}

// s, estimate of the shortest window if the deck does not give it: one sub-step, or the limit of
// the coupling. The rough step may be twice the real one; so half of it is used.
double shortest_window(const Model& model) {
  const auto& time = model.time;
  if (time.window > 0) return time.window;
  return std::min(time.step > 0 ? time.step : time.rough_step / 2, time.rough_window);
}

bool has_corners(const bed::BedParameters& bed) {
  const auto corners = [](const bed::LayerParameters& layer) {
    return layer.stone == bed::StoneKind::polyhedra || layer.stone == bed::StoneKind::compound ||
           layer.stone == bed::StoneKind::library;
  };
  return corners(bed) || std::any_of(bed.layers.begin(), bed.layers.end(), corners);
}

}  // namespace

// Spheres and clumps of spheres allow longer steps. A given step is not checked: the mass of the
// lightest stone is known only roughly from the deck.
void declare_steadiness(const Model& model, bool corners, input::Section& s) {
  const double steady = dem::steady_safety(model.physics);
  s.rule("dem.safety", !corners || model.time.step > 0 || model.dem.safety <= steady,
         fmt::format("may be too large for compacted stones with sticking contacts: with the given "
                     "k_n, k_s, zeta_n and zeta_s, energy increased in tests with a safety above "
                     "about {:.2f}; give at most this value",
                     steady),
         {.severity = input::Severity::warning,
          .reads = {"dem.safety", "time.step", "contact", model.stones_section()}});
  const double of_friction = dem::steady_friction(model.physics);
  s.rule("dem.safety", corners || model.time.step > 0 || model.dem.safety <= of_friction,
         fmt::format("is too large for the tangential damping of spheres: with the given k_n, k_s "
                     "and zeta_s, the tangential contact force changes its sign in each sub-step "
                     "if dem.safety is above about {:.2f}; give at most this value",
                     of_friction),
         {.severity = input::Severity::warning,
          .reads = {"dem.safety", "time.step", "contact", model.stones_section()}});
}

// In plane stress there is no confinement across the track, without which soil has hardly any
// strength.
void declare_ground_yields(const Model& model, input::Section& s) {
  s.rule("ground.plane",
         model.dimension != Dimension::plane || !model.ground.yields() ||
             model.ground.plane == fem::PlaneState::strain,
         "must be \"strain\" with layers that yield: in plane stress they have no confining "
         "pressure across the track",
         {.reads = {"dimension", "ground.plane", "ground.layer", "ground.block"}});
}

constexpr double fewest_windows = 4;  // in a cycle: zero, rise, peak, fall of a haversine

// Output is written at most once in a window; an
// interval below that is most likely in another unit.
void declare_intervals(const Model& model, input::Section& s) {
  const double window = shortest_window(model);
  const auto& output = model.output;
  for (const auto& [key, interval] : {std::pair{"output.history_interval", output.history_interval},
                                      {"output.fields_interval", output.fields_interval},
                                      {"output.checkpoint_interval", output.checkpoint_interval}})
    s.rule(key, interval == 0 || interval >= window * (1 - rounding_of_steps),
           fmt::format("is less than a time window (estimate: at least {:.2g} s): output is then "
                       "written after every window; is the interval in s?",
                       window),
           {.severity = input::Severity::warning, .reads = {key, "time", "dem", "bed", "contact"}});
  for (const Stage& stage : model.stages)
    s.rule("time.window", stage.duration <= 0 || model.time.window <= stage.duration,
           fmt::format("is longer than stage \"{}\" ({:g} s), which then lasts one window",
                       stage.name, stage.duration),
           {.severity = input::Severity::warning, .reads = {"time.window", "stage"}});
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const Stage& stage = model.stages[i];
    if (stage.cycles < 1 || stage.duration <= 0 || stage.kind == StageKind::jump) continue;
    const double cycle = stage.duration / static_cast<double>(stage.cycles);
    s.rule(fmt::format("stage[{}].cycles", i), cycle >= fewest_windows * window,
           fmt::format("gives cycles of {:.2g} s, which a time window of about {:.2g} s or more "
                       "does not resolve; give fewer cycles, or a longer duration",
                       cycle, window),
           {.reads = {"stage", "time", "dem", "bed", "contact"}});
  }
}

void declare_jump_period(const Model& model, input::Section& s) {
  const double window = shortest_window(model);
  s.rule("jump.period",
         !model.has_stage(StageKind::jump) || model.jump.period >= fewest_windows * window,
         fmt::format("is less than {:g} time windows of about {:.2g} s; give a longer period",
                     fewest_windows, window),
         {.reads = {"jump", "stage", "time", "dem", "bed", "contact"}});
}

std::size_t sleepers_up_to(const track::TrackParameters& track, double x) {
  std::size_t n = 0;
  while (n < track.sleepers() && track.sleeper_x(n) < x) ++n;
  return n;
}

void declare_rules(const Model& model, input::Section& s) {
  declare_stages(model, s);
  declare_layers(model, s);
  declare_profile(model, s);
  declare_ballast(model, s);
  declare_materials(model, s);
  declare_ground_below(model, s);
  declare_ground_sides(model, s);
  declare_ground_yields(model, s);
  declare_sleepers(model, s);
  declare_passages(model, s);
  declare_regions(model, s);
  declare_fields(model, s);
  declare_sensors(model, s);
  declare_oddities(model, s);
  declare_steadiness(model, has_corners(model.bed), s);
  declare_skin_of_bed(model, s);
  declare_walls(model, s);
  declare_tamping(model, s);
  declare_breakage(model, s);
  declare_bonds(model, s);
  bool periodic_known = true;
  for (const auto& axis : model.periodic) periodic_known &= axis == "x" || axis == "y";
  s.rule("periodic", periodic_known, "may contain only \"x\" and \"y\"", {.reads = {"periodic"}});
}

// The whole table is applied for each train of a stage.
std::vector<std::string> warnings_of_loads(const Model& model) {
  std::vector<std::string> warnings;
  const auto& sleepers = model.sleepers;
  if (!model.load.is_table() || sleepers.count < 1) return warnings;
  for (const Stage& stage : model.stages) {
    if (stage.kind != StageKind::passage || stage.train) continue;
    const track::SeatLoad load(model.load, sleepers.spacing,
                               static_cast<std::size_t>(sleepers.count));
    const double trains = static_cast<double>(std::max<std::int64_t>(stage.cycles, 1));
    const double time =
        stage.duration > 0 ? stage.duration / trains : load.duration(sleepers.last());
    for (const std::string& jump : load.jumps(sleepers.first, sleepers.last(), time))
      warnings.push_back(
          fmt::format("load.file: {}: stage \"{}\": {}", model.load.file, stage.name, jump));
  }
  return warnings;
}

}  // namespace trackbed::model
