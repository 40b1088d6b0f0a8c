// Rules of a train over the sleepers of a bed: sections of a track alone that a bed has only if a
// stage sends a train, and where track and bed must meet.
//
// Errors are what cannot be computed; a parameter of a track alone that a bed does not look at is a
// warning.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/coarse_steps.hpp"
#include "app/limits.hpp"
#include "app/rules.hpp"
#include "app/track_rules.hpp"
#include "trackbed/track/motion.hpp"

namespace trackbed::app {

namespace {

constexpr double rounding = 1e-6;  // relative, of lengths that are meant to be equal

// What solid rails and their pads do not look at either.
bool untouched(const Model& model) {
  TrackModel track = model.track;
  if (model.solid.rails) track.line.rail = {}, track.line.pad = {};
  return track.untouched();
}

// Sections of rail and train without a train would have no effect.
void declare_presence(const Model& model, input::Section& s) {
  s.rule(
      "model", model.has_train() || untouched(model),
      "must be \"track\", or a stage must have train = true: a section of rail and train is given "
      "(rail, pad, under_sleeper_pad, ballast, track, vehicle, train, wheel_rail, irregularity, "
      "irregularity_right, passage), and these have no effect otherwise",
      {.reads = {"model"}});
  const track::SeatParameters none;
  s.rule("seat",
         model.has_train() || (model.seat.before == none.before && model.seat.rails == none.rails),
         "has no effect: no stage has train = true", {.reads = {"seat", "stage"}});
  for (std::size_t i = 0; i < model.stages.size(); ++i)
    s.rule(fmt::format("stage[{}].train", i),
           !model.stages[i].train || model.stages[i].kind == StageKind::passage,
           "is for stages of kind passage only", {.reads = {"stage"}});
  const std::optional<double> stop = model.track.stop();
  for (std::size_t i = 0; i < model.stages.size(); ++i)
    s.rule(fmt::format("stage[{}].duration", i),
           !model.stages[i].train || model.stages[i].duration > 0 || !stop,
           fmt::format("must be above 0 s: the train stops with its first axle {:g} m behind the "
                       "begin of the track and never leaves it (train.speeds)",
                       stop.value_or(0)),
           {.reads = {"stage", "train", "vehicle", "track"}});
  for (std::size_t i = 0; i < model.stages.size(); ++i)
    s.rule(fmt::format("stage[{}].duration", i),
           !model.stages[i].train || model.stages[i].cycles < 2 || model.stages[i].duration == 0,
           "must be 0 for several trains: the next one is sent when the last axle has left",
           {.reads = {"stage"}});
}

// A stage that lasts as long as it is told may end before its train has come.
void declare_arrivals(const Model& model, input::Section& s) {
  const TrackModel& track = model.track;
  if (track.train.vehicles.empty() || !track.train.changes_are_clear()) return;
  const double bed = static_cast<double>(model.seat.before) * track.line.track.spacing;
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const Stage& stage = model.stages[i];
    if (!stage.train || stage.duration == 0) continue;
    const double reached = track::Motion(track.train).x(stage.duration);
    s.rule(fmt::format("stage[{}].duration", i), reached >= bed,
           fmt::format("ends the stage before the train is on the bed: its first axle gets to "
                       "{:.4g} m, the bed's first sleeper is at {:.4g} m of the track",
                       reached, bed),
           {.weight = input::Weight::warning, .reads = {"stage", "train", "seat", "track"}});
  }
}

// The sleepers of the bed are sleepers of the track, in its plain part.
void declare_place(const Model& model, input::Section& s) {
  const track::TrackParameters& track = model.track.line.track;
  const track::SleeperParameters& bed = model.sleepers;
  const input::About about{.reads = {"track", "sleepers", "seat", "stage"}};
  s.rule("track.support", track.support == track::Support::sleepers,
         "must be sleepers: the bed has some", about);
  s.rule("track.spacing", std::abs(track.spacing - bed.spacing) <= rounding * bed.spacing,
         fmt::format("must be that of the sleepers of the bed (sleepers.spacing = {:g} m)",
                     bed.spacing),
         about);
  const double first = static_cast<double>(model.seat.before) * track.spacing;
  const double last = first + static_cast<double>(bed.count - 1) * track.spacing;
  s.rule("seat.before", first >= track.run_in * (1 - rounding),
         fmt::format("puts the first sleeper of the bed {:g} m behind the begin of the track, "
                     "within its run-in of {:g} m",
                     first, track.run_in),
         about);
  s.rule("track.length", last <= (track.length - track.run_in) * (1 + rounding),
         fmt::format("must be at least {:g} m: {:g} m up to the last sleeper of the bed, and the "
                     "run-in behind it",
                     last + track.run_in, last),
         about);
  s.rule("train.start", model.track.train.start <= 0,
         "must be at most 0 on a bed: the train comes from the rigid rail before the track",
         {.reads = {"train", "stage"}});
}

// Below the bed's sleepers are stones; of zones these have the rail alone.
void declare_zones(const Model& model, input::Section& s) {
  const track::TrackParameters& track = model.track.line.track;
  for (std::size_t i = 0; i < track.zones.size(); ++i) {
    const track::TrackZone& zone = track.zones[i];
    std::int64_t over = 0;
    for (std::int64_t k = 0; k < model.sleepers.count; ++k) {
      const double x = static_cast<double>(model.seat.before + k) * track.spacing;
      over += zone.covers(x, 0, track.length) || zone.covers(x, 1, track.length);
    }
    s.rule(fmt::format("track.zone[{}].from", i), over == 0 || (zone.bed == 1 && zone.gap == 0),
           fmt::format("begins a zone over {} sleeper{} of the bed: stones bear {}, `bed` and "
                       "`gap` have no effect there",
                       over, over == 1 ? "" : "s", over == 1 ? "it" : "them"),
           {.weight = input::Weight::warning, .reads = {"track", "sleepers", "seat", "stage"}});
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
         seats.size() == 2 && std::abs(seats[0] + seats[1]) <= rounding * side &&
             std::abs(std::abs(seats[0]) - side) <= rounding * side,
         fmt::format("must be [{0:g}, -{0:g}] below two rails (track.dimension = \"space\"), half "
                     "of track.gauge to either side",
                     side),
         about);
}

// Seats of a table are those of sleepers that roll, as below two rails.
void declare_seats(const Model& model, input::Section& s) {
  const double gauge = model.load.gauge, length = model.sleepers.length;
  if (gauge == 0) return;
  const input::About about{.reads = {"load", "sleepers", "dimension", "stage", "track"}};
  s.rule("load.gauge", model.dimension == Dimension::space,
         "must be 0 in a plane model, whose sleepers do not roll (dimension)", about);
  s.rule("load.gauge", model.sleepers.model == track::SleeperBody::rigid,
         "must be 0 on solid sleepers (sleepers.model), whose seats share one load", about);
  s.rule("load.gauge", gauge < length,
         fmt::format("must be below the length of the bed's sleepers, which is {:g} m", length),
         about);
  s.rule("load.gauge", !model.has_train(),
         "must be 0 in a deck with a train (train = true), whose rails say where seats are", about);
  const auto& free = model.sleepers.free;
  s.rule("load.gauge", std::find(free.begin(), free.end(), "rx") != free.end(),
         "has no effect: sleepers do not roll (sleepers.free lacks rx)",
         {.weight = input::Weight::warning, .reads = about.reads});
}

// Two rails lie on two seats of each sleeper, which rolls below them.
void declare_sides(const Model& model, input::Section& s) {
  if (model.track.line.track.dimension == Dimension::plane) return;
  const input::About about{.reads = {"track", "sleepers", "seat", "stage", "dimension"}};
  s.rule("track.dimension", model.dimension == Dimension::space,
         "must be plane in a plane model, whose sleepers do not roll (dimension)", about);
  s.rule("seat.rails", model.seat.rails == 2,
         "must be 2 below two rails (track.dimension = \"space\")", about);
  const double gauge = model.track.line.track.gauge, length = model.sleepers.length;
  s.rule("track.gauge", gauge < length,
         fmt::format("must be below the length of the bed's sleepers, which is {:g} m", length),
         about);
  s.rule("track.sleeper_length", model.track.line.track.sleeper_length > gauge,
         fmt::format("must be longer than the gauge of {:g} m: rails lie on the sleepers", gauge),
         about);
  if (model.sleepers.model == track::SleeperBody::solid) return declare_solid_sides(model, s);
  const auto& free = model.sleepers.free;
  s.rule("sleepers.free", std::find(free.begin(), free.end(), "rx") != free.end(),
         "lacks rx: sleepers of the bed do not roll below two rails, those on springs do",
         {.weight = input::Weight::warning, .reads = about.reads});
}

// The bed's sleeper of each rail is about as heavy as that on springs, or a mass was meant whole.
void declare_doubts(const Model& model, input::Section& s) {
  const track::SleeperParameters& bed = model.sleepers;
  const double length = model.dimension == Dimension::plane ? model.thickness : bed.length;
  const double mass = bed.density * bed.width * bed.height * length / model.seat.rails;
  const track::TrackParameters& track = model.track.line.track;
  const double given = track.sleeper_mass / static_cast<double>(track.rails);
  constexpr double far = 2;
  s.rule("seat.rails", mass <= far * given && given <= far * mass,
         fmt::format("leaves {:.3g} kg of the bed's sleepers to each rail, of those on springs "
                     "{:.3g} kg (track.sleeper_mass): which share do they carry?",
                     mass, given),
         {.weight = input::Weight::warning,
          .reads = {"track", "sleepers", "seat", "stage", "material", "thickness"}});
  const TrackOutput none;
  const TrackOutput& passage = model.track.passage;
  const auto unused = [&](const char* key, bool given_one, const char* instead) {
    s.rule(key, !given_one, fmt::format("has no effect on a bed: {} counts", instead),
           {.weight = input::Weight::warning, .reads = {key, "stage"}});
  };
  unused("passage.duration", passage.duration != none.duration, "the duration of the stage");
  unused("passage.history_interval", passage.history_interval != none.history_interval,
         "output.history_interval");
  unused("passage.checkpoint_interval", passage.checkpoint_interval != none.checkpoint_interval,
         "output.checkpoint_interval");
  unused("passage.wall_time", passage.wall_time != none.wall_time, "output.wall_time");
  unused("passage.stop_after", passage.stop_after != none.stop_after, "output.stop_after");
  unused("passage.points", passage.points != none.points,
         "the rail above each sleeper is in the histories, so only that");
}

// s, about: stones that are not drawn yet limit windows as well.
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
  declare_seats(model, s);
  if (!model.has_train()) return;
  declare_arrivals(model, s);
  declare_place(model, s);
  declare_zones(model, s);
  if (model.track.is_countable()) {
    declare_ballast_mass(model.track, model.seat.before, model.sleepers.count, s);
    declare_coarse_steps(model.track, longest_window(model), s);
  }
  declare_sides(model, s);
  declare_doubts(model, s);
}

}  // namespace trackbed::app
