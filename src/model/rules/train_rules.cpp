// Rules of a train over the sleepers of a bed: sections of a track alone that a bed has only with a
// stage with a train, and parameters in which track and bed must agree.
//
// A deck that cannot be computed is an error; a parameter of a track alone that a bed does not use
// gives a warning.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "model/rules/limits.hpp"
#include "model/rules/rules.hpp"
#include "model/track_rules/coarse_steps.hpp"
#include "model/track_rules/track_rules.hpp"
#include "trackbed/track/motion.hpp"

namespace trackbed::model {

namespace {

constexpr double alike = 1e-6;  // relative, of lengths that are meant to be equal

// Sections of a track that would have no effect without a train; solid rails use rail and pad.
std::vector<std::string> idle_sections(const Model& model) {
  if (model.has_train()) return {};
  TrackModel track = model.track;
  if (model.solid.rails) track.line.rail = {}, track.line.pad = {};
  return track.given_sections();
}

// A rail can be kept only after a train that ran on it.
void declare_kept_rails(const Model& model, input::Section& s) {
  bool before = false;
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const Stage& stage = model.stages[i];
    const std::string key = fmt::format("stage[{}].rail", i);
    const bool kept = stage.rail == RailState::kept;
    s.rule(key, !kept || stage.train, "has an effect only with train = true; leave it out",
           {.reads = {"stage"}});
    s.rule(key, !kept || !stage.train || before,
           "must be \"laid\": no stage with train = true comes before this one",
           {.reads = {"stage"}});
    before = before || stage.train;
  }
}

// Sections of rail and train without a train would have no effect.
void declare_presence(const Model& model, input::Section& s) {
  const std::vector<std::string> idle = idle_sections(model);
  s.rule(
      "model", idle.empty(),
      fmt::format("the deck has sections of rail and train ({}), which need a stage with train = "
                  "true, or model = \"track\" or \"track_on_ground\"",
                  fmt::join(idle, ", ")),
      {.reads = {"model"}});
  const track::SeatParameters none;
  s.rule("seat",
         model.has_train() || (model.seat.before == none.before && model.seat.rails == none.rails),
         "has no effect: no stage has train = true", {.reads = {"seat", "stage"}});
  for (std::size_t i = 0; i < model.stages.size(); ++i)
    s.rule(fmt::format("stage[{}].train", i),
           !model.stages[i].train || model.stages[i].kind == StageKind::passage,
           "is for stages of kind passage only", {.reads = {"stage"}});
  declare_kept_rails(model, s);
  const std::optional<double> stop = model.track.stop();
  for (std::size_t i = 0; i < model.stages.size(); ++i)
    s.rule(fmt::format("stage[{}].duration", i),
           !model.stages[i].train || model.stages[i].duration > 0 || !stop,
           fmt::format("must be above 0 s: the train stops with its first axle at {:g} m from the "
                       "start of the track and never leaves it (train.speeds)",
                       stop.value_or(0)),
           {.reads = {"stage", "train", "vehicle", "track"}});
  for (std::size_t i = 0; i < model.stages.size(); ++i)
    s.rule(fmt::format("stage[{}].duration", i),
           !model.stages[i].train || model.stages[i].cycles < 2 || model.stages[i].duration == 0,
           "must be 0 for several trains: each train starts when the last axle of the train before "
           "has left",
           {.reads = {"stage"}});
}

// A stage with a given duration may end before its train has arrived.
void declare_arrivals(const Model& model, input::Section& s) {
  const TrackModel& track = model.track;
  if (track.train.vehicles.empty() || !track.train.changes_are_valid()) return;
  const double bed = track.line.track.sleeper_x(static_cast<std::size_t>(model.seat.before));
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const Stage& stage = model.stages[i];
    if (!stage.train || stage.duration == 0) continue;
    const double reached = track::Motion(track.train).x(stage.duration);
    s.rule(fmt::format("stage[{}].duration", i), reached >= bed,
           fmt::format(
               "ends the stage before the train is on the bed: the first axle reaches {:.4g} m "
               "from the start of the track, and the first sleeper of the bed is at {:.4g} m",
               reached, bed),
           {.severity = input::Severity::warning, .reads = {"stage", "train", "seat", "track"}});
    const std::optional<track::Train> train = train_of(track);
    if (reached < bed || !train || track.stop()) continue;  // one that stops never leaves
    const double last = reached - train->axle_distance();
    const double end = bed + model.sleepers.last() - model.sleepers.first;
    s.rule(
        fmt::format("stage[{}].duration", i), last >= end,
        fmt::format("ends the stage before the train has left the bed: the last axle reaches "
                    "{:.4g} m from the start of the track, and the last sleeper of the bed is "
                    "at {:.4g} m; with a duration of 0 it lasts until the train has left the track",
                    last, end),
        {.severity = input::Severity::warning,
         .reads = {"stage", "train", "vehicle", "seat", "track", "sleepers"}});
  }
}

// The sleepers of the bed are sleepers of the track, between its run-ins.
void declare_place(const Model& model, input::Section& s) {
  const track::TrackParameters& track = model.track.line.track;
  const track::SleeperParameters& bed = model.sleepers;
  const input::About about{.reads = {"track", "sleepers", "seat", "stage"}};
  s.rule("track.support", track.support == track::Support::sleepers,
         "must be \"sleepers\", since the bed has sleepers", about);
  s.rule("track.spacing", std::abs(track.spacing - bed.spacing) <= alike * bed.spacing,
         fmt::format("must be that of the sleepers of the bed (sleepers.spacing = {:g} m)",
                     bed.spacing),
         about);
  const auto before = static_cast<std::size_t>(model.seat.before);
  const double first = track.sleeper_x(before);
  const double last = track.sleeper_x(before + static_cast<std::size_t>(bed.count) - 1);
  bool even = true;
  for (std::size_t k = 0; k < static_cast<std::size_t>(bed.count); ++k)
    even = even && std::abs(track.sleeper_x(before + k) - first -
                            static_cast<double>(k) * bed.spacing) <= alike * track.length;
  s.rule("track.zone", even || std::abs(track.spacing - bed.spacing) > alike * bed.spacing,
         fmt::format("`spacing` must be 0 on the sleepers of the bed, which are {:g} m apart "
                     "(sleepers.spacing): {:g} to {:g} m of the track",
                     bed.spacing, first, first + bed.last() - bed.first),
         about);
  s.rule(
      "seat.before", first >= track.run_in * (1 - alike),
      fmt::format("puts the first sleeper of the bed at {:g} m from the start of the track, within "
                  "its run-in of {:g} m; give at least {} sleepers before the bed, or a shorter "
                  "track.run_in",
                  first, track.run_in, sleepers_up_to(track, track.run_in * (1 - alike))),
      about);
  s.rule("track.length", last <= (track.length - track.run_in) * (1 + alike),
         fmt::format("must be at least {:g} m: {:g} m up to the last sleeper of the bed, and the "
                     "run-out beyond it",
                     last + track.run_in, last),
         about);
  s.rule(
      "train.start", model.track.train.start <= 0,
      "must be given and be at most 0 m on a bed: the train comes from the rigid rail before the "
      "track",
      {.reads = {"train", "stage"}});
}

// Beside the outermost sleepers of the bed are sleepers on springs, which should be beyond its
// ends.
void declare_ends(const Model& model, input::Section& s) {
  const track::SleeperParameters& bed = model.sleepers;
  const std::vector<double>& x = model.bed.x;
  if (!model.has_bed() || x.size() != 2) return;
  // At an end a bed may continue by one and a half spacings, as at that of a row of cells.
  const auto bare = [&](double space) { return space > (1.5 + alike) * bed.spacing; };
  const double before = bed.first - x[0], behind = x[1] - bed.last();
  const auto words = [&](double space, const char* where) {
    return fmt::format(
        "leaves {:.3g} m of the bed (x = {:g} to {:g} m) {} sleeper bare: the rail lies there on "
        "springs ([ballast]) instead of stones",
        space, x[0], x[1], where);
  };
  const input::About about{.severity = input::Severity::warning,
                           .reads = {"sleepers", "bed", "track", "stage"}};
  s.rule("sleepers.first", !bare(before), words(before, "before the first"), about);
  s.rule("sleepers.count", !bare(behind), words(behind, "behind the last"), about);
}

// A rail distributes the load of a wheel over several sleepers; that below it carries a third to
// two thirds. A bed that was loaded by less than it is to carry may settle under the train.
void declare_bedding_in(const Model& model, input::Section& s) {
  constexpr double least = 0.6, most = 5;  // of the load of a wheel
  if (!train_of(model.track)) return;
  const track::TrackParameters& line = model.track.line.track;
  const track::Train train(model.track.train, model.track.vehicles, line.rails, line.wheel_gauge());
  // N, of the wheels that a sleeper of the model carries
  const double wheel = train.largest_static_load() * model.seat.rails;
  double loaded = 0;  // N
  std::size_t last = 0;
  bool passed = false;  // by the axles of [load], whose size is not compared
  for (std::size_t i = 0; i < model.stages.size() && !model.stages[i].train; ++i) {
    const Stage& stage = model.stages[i];
    passed = passed || stage.kind == StageKind::passage;
    const double load = stage.kind == StageKind::load ? stage.load + stage.seat_force : 0;
    if (load > loaded) loaded = load, last = i;
  }
  if (passed) return;
  s.rule("stage", !model.start.empty() || loaded > 0,
         "no stage of kind load loads the sleepers downwards before the first train: the bed has "
         "not been bedded in and settles under the train",
         {.severity = input::Severity::warning, .reads = {"stage", "start"}});
  const std::string key = fmt::format("stage[{}].load", last);
  const input::About about{.severity = input::Severity::warning,
                           .reads = {"stage", "train", "vehicle", "track"}};
  s.rule(key, loaded == 0 || loaded >= least * wheel,
         fmt::format("loads each sleeper by {:.3g} kN together with seat_force, less than {:g} "
                     "times the largest static load of the wheels above it, {:.3g} kN: the train "
                     "may bring more, of which the bed would settle",
                     loaded / 1e3, least, wheel / 1e3),
         about);
  s.rule(key, wheel == 0 || loaded <= most * wheel,
         fmt::format("loads each sleeper by {:.3g} kN together with seat_force, more than {:g} "
                     "times the largest static load of the wheels above it, {:.3g} kN; is it in N?",
                     loaded / 1e3, most, wheel / 1e3),
         about);
}

// A ground that never moves supports the stones like a floor, whatever its layers are; local
// damping acts against every motion, that under the train, too.
void declare_motion(const Model& model, input::Section& s) {
  constexpr double strong = 0.3;
  bool moves = !model.ground.present;
  for (const Stage& stage : model.stages) moves = moves || stage.ground_moves;
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const Stage& stage = model.stages[i];
    if (!stage.train) continue;
    s.rule(fmt::format("stage[{}].ground_moves", i), moves,
           "is false in every stage: the ground stays rigid, so that its layers and blocks have no "
           "effect on the train",
           {.severity = input::Severity::warning, .reads = {"stage", "ground.present"}});
    s.rule(fmt::format("stage[{}].local_damping", i), stage.local_damping <= strong,
           fmt::format("is large in a stage with a train (above {:g}): it takes away this part of "
                       "every unbalanced force on the stones",
                       strong),
           {.severity = input::Severity::warning, .reads = {"stage"}});
  }
}

// The bed's sleepers have their own mass and lie on stones: zones affect only rail, pads
// and the gap there.
void declare_zones(const Model& model, input::Section& s) {
  const track::TrackParameters& track = model.track.line.track;
  for (std::size_t i = 0; i < track.zones.size(); ++i) {
    const track::TrackZone& zone = track.zones[i];
    std::int64_t over = 0;
    for (std::int64_t k = 0; k < model.sleepers.count; ++k) {
      const double x = track.sleeper_x(static_cast<std::size_t>(model.seat.before + k));
      over += zone.covers(x, 0, track.length) || zone.covers(x, 1, track.length);
    }
    s.rule(fmt::format("track.zone[{}].from", i), over == 0 || (zone.bed == 1 && zone.sleeper == 1),
           fmt::format("begins a zone that contains {} sleeper{} of the bed: {} on stones and {} a "
                       "mass of {} own, so that `bed` and `sleeper` have no effect there (zones "
                       "count from the start of the track, where the bed's sleepers are from {:g} "
                       "to {:g} m)",
                       over, over == 1 ? "" : "s", over == 1 ? "this one lies" : "these lie",
                       over == 1 ? "has" : "have", over == 1 ? "its" : "their",
                       track.sleeper_x(static_cast<std::size_t>(model.seat.before)),
                       track.sleeper_x(
                           static_cast<std::size_t>(model.seat.before + model.sleepers.count - 1))),
           {.severity = input::Severity::warning, .reads = {"track", "sleepers", "seat", "stage"}});
  }
}

// Whole sleepers, with a seat below each rail.
void declare_solid_sides(const Model& model, input::Section& s) {
  const input::About about{.reads = {"track", "sleepers", "solid", "stage"}};
  s.rule("solid.half", !model.solid.half,
         "must be false below two rails (track.dimension = \"space\")", about);
  const std::vector<double>& seats = model.solid.seats;
  const double side = model.track.line.track.gauge / 2;
  s.rule("solid.seats",
         seats.size() == 2 && std::abs(seats[0] + seats[1]) <= alike * side &&
             std::abs(std::abs(seats[0]) - side) <= alike * side,
         fmt::format("must be [{0:g}, -{0:g}] below two rails (track.dimension = \"space\"), half "
                     "of track.gauge to either side",
                     side),
         about);
}

// A table for two seats per sleeper needs sleepers that roll, as below two rails.
void declare_seats_of_train(const Model& model, input::Section& s) {
  const double gauge = model.load.gauge, length = model.sleepers.length;
  if (gauge == 0) return;
  const input::About about{.reads = {"load", "sleepers", "dimension", "stage", "track"}};
  s.rule("load.gauge", model.dimension == Dimension::space,
         "must be 0 in a plane model, whose sleepers do not roll (dimension)", about);
  s.rule("load.gauge", model.sleepers.model == track::SleeperBody::rigid,
         "must be 0 on solid sleepers (sleepers.model), whose seats have equal loads", about);
  s.rule("load.gauge", gauge < length,
         fmt::format("must be below the length of the bed's sleepers, which is {:g} m", length),
         about);
  s.rule("load.gauge", !model.has_train(),
         "must be 0 in a deck with a train (train = true), whose rails define the seats", about);
  const auto& free = model.sleepers.free;
  s.rule("load.gauge", std::find(free.begin(), free.end(), "rx") != free.end(),
         "has no effect: sleepers do not roll (sleepers.free does not contain rx)",
         {.severity = input::Severity::warning, .reads = about.reads});
}

// Two rails rest on two seats of each sleeper, which rolls below them.
void declare_sides(const Model& model, input::Section& s) {
  if (model.track.line.track.dimension == Dimension::plane) return;
  const input::About about{.reads = {"track", "sleepers", "seat", "stage", "dimension"}};
  s.rule("track.dimension", model.dimension == Dimension::space,
         "must be \"plane\" in a plane model, whose sleepers do not roll (dimension)", about);
  s.rule("seat.rails", model.seat.rails == 2,
         "must be 2 if track.dimension = \"space\": the bed then carries both rails", about);
  const double gauge = model.track.line.track.gauge, length = model.sleepers.length;
  s.rule("track.gauge", gauge < length,
         fmt::format("must be below the length of the bed's sleepers, which is {:g} m", length),
         about);
  s.rule("track.sleeper_length", model.track.line.track.sleeper_length > gauge,
         fmt::format("must be above the distance of the rail centrelines, track.gauge = {:g} m: "
                     "rails rest on the sleepers",
                     gauge),
         about);
  if (model.sleepers.model == track::SleeperBody::solid) return declare_solid_sides(model, s);
  const auto& free = model.sleepers.free;
  s.rule("sleepers.free", std::find(free.begin(), free.end(), "rx") != free.end(),
         "does not contain rx: the sleepers of the bed therefore cannot rotate about x, while the "
         "sleepers on springs can",
         {.severity = input::Severity::warning, .reads = about.reads});
}

// Whether fields are written in a stage with a train.
bool writes_the_train(const Model& model) {
  const std::vector<std::string>& names = model.output.fields_stages;  // empty: all
  return model.output.fields &&
         std::any_of(model.stages.begin(), model.stages.end(), [&](const Stage& stage) {
           return stage.train && (names.empty() ||
                                  std::find(names.begin(), names.end(), stage.name) != names.end());
         });
}

// The mass per rail of sleepers of the bed and on springs should be similar; otherwise one of them
// is most likely that of the whole sleeper.
void declare_warnings(const Model& model, input::Section& s) {
  const track::SleeperParameters& bed = model.sleepers;
  const double length = model.dimension == Dimension::plane ? model.thickness : bed.length;
  const double mass = bed.density * bed.width * bed.height * length / model.seat.rails;
  const track::TrackParameters& track = model.track.line.track;
  const double given = track.sleeper_mass / static_cast<double>(track.rails);
  constexpr double far = 1.6;  // less than the number of rails
  s.rule("seat.rails", mass <= far * given && given <= far * mass,
         fmt::format(
             "gives {:.3g} kg per rail for a sleeper of the bed (of its density and size), but "
             "a sleeper on springs has {:.3g} kg per rail (track.sleeper_mass): check the "
             "number of rails, [sleepers] and the density of its material",
             mass, given),
         {.severity = input::Severity::warning,
          .reads = {"track", "sleepers", "seat", "stage", "material", "thickness"}});
  // Extremes below a wheel are seen if each sleeper has a row with the wheel near it.
  double fastest = model.track.train.speed;
  for (const double speed : model.track.train.speeds) fastest = std::max(fastest, speed);
  const double between = fastest * model.output.history_interval;
  s.rule(
      "output.history_interval", between <= bed.spacing,
      fmt::format("lets the train move {:.3g} m between two rows of the histories, more than the "
                  "sleeper spacing ({:g} m): peaks below its wheels are missed; give at most "
                  "{:.2g} s",
                  between, bed.spacing, bed.spacing / 2 / fastest),
      {.severity = input::Severity::warning, .reads = {"output", "train", "sleepers", "stage"}});
  const double passing = track.length / std::max(fastest, 1e-9);  // s, of an axle
  s.rule("output.fields_interval",
         !writes_the_train(model) || model.output.fields_interval < passing,
         fmt::format("is longer than an axle takes over the track, {:.3g} s: hardly any file shows "
                     "the train; give at most {:.2g} s for a film",
                     passing, passing / 30),
         {.severity = input::Severity::warning, .reads = {"output", "train", "track", "stage"}});
  const TrackOutput none;
  const TrackOutput& passage = model.track.passage;
  const auto unused = [&](const char* key, bool given_one, const char* instead) {
    s.rule(key, !given_one, fmt::format("has no effect on a bed: {}", instead),
           {.severity = input::Severity::warning, .reads = {key, "stage"}});
  };
  unused("passage.duration", passage.duration != none.duration, "use the duration of the stage");
  unused("passage.points", passage.points != none.points,
         "the histories contain the rail above each sleeper");
}

// s, approximate: stones, which are not drawn yet, limit windows as well.
double longest_window(const Model& model) {
  if (model.time.window > 0) return model.time.window;
  double window = 0;
  for (const Stage& stage : model.stages)
    if (stage.train) window = std::max(window, coupling_limit(model, stage).window);
  const double step = model.time.step > 0 ? model.time.step : model.time.rough_step;
  return std::min(window, step * static_cast<double>(model.time.substeps));
}

}  // namespace

void declare_train(const Model& model, input::Section& s) {
  declare_presence(model, s);
  declare_seats_of_train(model, s);
  if (!model.has_train()) return;
  declare_arrivals(model, s);
  declare_place(model, s);
  declare_ends(model, s);
  declare_bedding_in(model, s);
  declare_motion(model, s);
  declare_zones(model, s);
  if (model.track.is_countable()) {
    declare_ballast_mass(model.track, model.seat.before, model.sleepers.count, s);
    declare_coarse_steps(model.track, longest_window(model), s);
  }
  declare_sides(model, s);
  declare_warnings(model, s);
}

}  // namespace trackbed::model
