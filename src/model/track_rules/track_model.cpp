// Sections of a track alone, and rules that tie them together.
#include "trackbed/model/track_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "model/track_rules/track_rules.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/input/values.hpp"
#include "trackbed/track/motion.hpp"
#include "trackbed/track/vehicle_layout.hpp"

namespace trackbed::model {

namespace {

bool by_seats(const TrackModel& model) { return model.passage.loaded_by == track::LoadedBy::seats; }

// Seat loads replace rail and train. The equations still contain the rail, which without pads only
// pinned ends hold.
void declare_seats(const TrackModel& model, input::Section& s) {
  const input::About about{.reads = {"passage", "train", "force", "track", "load"}};
  if (!by_seats(model))
    return s.rule("load", model.on_bed || !input::differs_from_default(model.load),
                  "has no effect: it acts only with passage.loaded_by = \"seats\"", about);
  s.rule("load.gauge", model.load.gauge == 0,
         "must be 0 except on a bed: without a bed, both seats of a sleeper receive the same load",
         about);
  s.rule("passage.loaded_by", !model.on_bed,
         "must be \"train\" in a model with a bed: there the stages define the loads", about);
  s.rule("train.vehicles", model.train.vehicles.empty(),
         "must be [] with passage.loaded_by = \"seats\": seat loads replace the train", about);
  s.rule(
      "force", model.passage.forces.empty(),
      "needs a rail, but seat loads act in place of rail and train (passage.loaded_by = \"seats\")",
      about);
  s.rule("track.support", model.line.track.support == track::Support::sleepers,
         "must be \"sleepers\" if seat loads are applied (passage.loaded_by)", about);
  s.rule("load.axles", model.load.is_table() || !model.load.axles.empty(),
         "must be given with passage.loaded_by = \"seats\": the distance of each axle behind the "
         "first in m, for example [0, 2.8] for a bogie",
         about);
  s.rule("track.ends", model.line.track.ends == track::RailEnds::pinned,
         "must be \"pinned\" if seat loads are applied (passage.loaded_by): there are then no "
         "pads, and without pinned ends nothing would support the rail, which remains in the "
         "model without effect on the sleepers",
         about);
}

// As numbers, which do not overflow: a wrong unit may give any of them.
double elements_of(const track::TrackParameters& track) {
  double usual = track.length, bays = 0;
  for (const track::TrackZone& zone : track.zones)
    if (zone.spacing > 0) {
      usual -= zone.to - zone.from;
      bays += (zone.to - zone.from) / zone.spacing;
    }
  return (bays + std::max(usual, 0.0) / track.spacing) * static_cast<double>(track.elements);
}

constexpr double most_elements = 1e6;

// So that a wrong unit gives an error before memory is exhausted.
void declare_size(const TrackModel& model, input::Section& s) {
  const track::TrackParameters& track = model.line.track;
  double least = track.spacing;
  std::string key = "track.spacing";
  for (std::size_t i = 0; i < track.zones.size(); ++i)
    if (const double apart = track.zones[i].spacing; apart > 0 && apart < least)
      least = apart, key = fmt::format("track.zone[{}].spacing", i);
  s.rule(key, model.is_countable(),
         fmt::format("gives {:.3g} elements for {:g} m of rail; at most {:g} are possible; is the "
                     "spacing in m?",
                     elements_of(track), track.length, most_elements),
         {.reads = {"track"}});
}

// Names of vehicles must be unique: trains refer to them.
void declare_vehicles(const TrackModel& model, input::Section& s) {
  const std::vector<std::string> known = track::vehicle_names(model.vehicles);
  s.rule("train.vehicles",
         !model.train.vehicles.empty() || !model.passage.forces.empty() || by_seats(model),
         "must name at least one vehicle, or there must be a [[force]] or seat loads "
         "(passage.loaded_by)",
         {.reads = {"train.vehicles", "force", "passage.loaded_by"}});
  for (const std::string& name : model.train.vehicles) {
    const std::string why = track::why_no_vehicle(name, model.vehicles);
    s.rule("train.vehicles", why.empty(), why, {.reads = {"train.vehicles", "vehicle"}});
  }
  for (std::size_t i = 0; i < model.vehicles.size(); ++i)
    s.rule(fmt::format("vehicle[{}].name", i),
           std::count(known.begin(), known.end(), model.vehicles[i].name) == 1,
           "is already the name of another vehicle of the deck or of the library",
           {.reads = {"vehicle"}});
}

bool runs(const TrackModel& model, const track::VehicleParameters& vehicle) {
  const std::vector<std::string>& names = model.train.vehicles;
  return std::find(names.begin(), names.end(), vehicle.name) != names.end();
}

void declare_unused_vehicles(const TrackModel& model, input::Section& s) {
  for (std::size_t i = 0; i < model.vehicles.size(); ++i)
    s.rule(fmt::format("vehicle[{}].name", i), runs(model, model.vehicles[i]),
           "is no vehicle of the train (train.vehicles): this table has no effect",
           {.severity = input::Severity::warning, .reads = {"vehicle", "train.vehicles"}});
}

// A vehicle is stable on both rails while m_body |offset| < m gauge/2: then the static load of
// every wheel is positive, since axles carry equal loads.
void declare_tipping(const TrackModel& model, input::Section& s) {
  if (model.line.track.dimension == Dimension::plane) return;
  for (std::size_t i = 0; i < model.vehicles.size(); ++i) {
    const track::VehicleParameters whole = track::complete(model.vehicles[i]);
    if (whole.body_offset == 0 || !runs(model, whole) || !track::lacking(whole).empty()) continue;
    if (!track::layout_of(whole.kind).body) continue;
    const double most = track::mass_of(whole) * model.line.track.gauge / (2 * whole.body_mass);
    s.rule(fmt::format("vehicle[{}].body_offset", i), std::abs(whole.body_offset) < most,
           fmt::format("tips the vehicle over: on rails {:g} m apart (track.gauge) its magnitude "
                       "must be below {:.4g} m",
                       model.line.track.gauge, most),
           {.reads = {"vehicle", "train.vehicles", "track"}});
  }
}

// Steps must resolve the rise and fall of a force.
void declare_force_in_time(const track::RailForce& force, const std::string& name, double step,
                           input::Section& s) {
  const bool impact = force.kind == track::ForceKind::impact;
  const std::string key = name + (impact ? ".length" : ".frequency");
  const double time = force.duration();
  const std::string words = fmt::format("gives {} of {:.3g} s: steps of {:g} s (passage.step)",
                                        impact ? "an impact" : "periods", time, step);
  const char* them = impact ? "it" : "them";
  const input::About about{.reads = {"force", "passage.step"}};
  constexpr double needed = 2, enough = 8;  // steps
  s.rule(key, time > needed * step,
         fmt::format("{} do not resolve {} (more than 2 steps are required); give a shorter step",
                     words, them),
         about);
  s.rule(key, time <= needed * step || time >= enough * step,
         fmt::format("{} resolve {} poorly (8 steps or more are recommended); give a shorter step",
                     words, them),
         {.severity = input::Severity::warning, .reads = about.reads});
}

// The displacement of a pinned end is zero.
void declare_force_at_end(const track::RailForce& force, const std::string& name,
                          const track::TrackParameters& track, input::Section& s) {
  constexpr double rounding = 1e-9;  // m
  const bool end = force.at < rounding || std::abs(force.at - track.length) < rounding;
  s.rule(name + ".at", !end || track.ends != track::RailEnds::pinned,
         "is an end of the rail, which is pinned (track.ends): the force has no effect",
         {.severity = input::Severity::warning, .reads = {"force", "track"}});
}

// s, until the last axle has left unless it is given; infinite if it never does.
double duration_of(const TrackModel& model) {
  if (model.passage.duration > 0) return model.passage.duration;
  const std::optional<track::Train> train = train_of(model);
  if (!train || train->wheels().empty() || !model.train.changes_are_valid())
    return std::numeric_limits<double>::infinity();
  return track::Motion(model.train).time_at(model.line.track.length + train->axle_distance());
}

// Without vehicles the duration of the run must be given.
void declare_forces(const TrackModel& model, input::Section& s) {
  const double length = model.line.track.length, lasts = duration_of(model);
  for (std::size_t i = 0; i < model.passage.forces.size(); ++i)
    s.rule(fmt::format("force[{}].at", i), model.passage.forces[i].at <= length,
           fmt::format("is beyond the track, which is {:g} m long", length),
           {.reads = {"force", "track.length"}});
  for (std::size_t i = 0; i < model.passage.forces.size(); ++i) {
    const std::string name = fmt::format("force[{}]", i);
    if (!model.on_ground)  // which may divide the step: checked once it is known
      declare_force_in_time(model.passage.forces[i], name, model.passage.step, s);
    declare_force_at_end(model.passage.forces[i], name, model.line.track, s);
    s.rule(name + ".begin", model.passage.forces[i].begin < lasts,
           fmt::format("is after the end of the run at {:.4g} s: the force has no effect", lasts),
           {.severity = input::Severity::warning,
            .reads = {"force", "passage.duration", "train", "vehicle", "track"}});
  }
  s.rule("force", !model.on_bed || model.passage.forces.empty(),
         "is for a track alone or on a ground, not for a bed", {.reads = {"force", "model"}});
  s.rule("passage.duration",
         !model.train.vehicles.empty() || model.passage.duration > 0 || by_seats(model),
         "must be above 0 s without vehicles",
         {.reads = {"train.vehicles", "passage.duration", "force"}});
}

// Parameters that need two rails.
void declare_sides(const TrackModel& model, input::Section& s) {
  const bool space = model.line.track.dimension == Dimension::space;
  const input::About about{.reads = {"track", "irregularity", "irregularity_right", "force"}};
  using Kind = track::IrregularityKind;
  s.rule("irregularity.kind", model.irregularity.kind != Kind::same,
         "\"same\" is only for the right rail (irregularity_right)", about);
  s.rule("irregularity_right.kind", space || model.irregularity_right.kind == Kind::same,
         "needs two rails (track.dimension = \"space\")", about);
  const track::TrackParameters& track = model.line.track;
  const bool two_seats = space && track.support == track::Support::sleepers && !model.on_bed;
  s.rule("track.sleeper_length", !two_seats || track.sleeper_length > track.gauge,
         fmt::format("must be above the distance of the rail centrelines, track.gauge = {:g} m: "
                     "rails rest on the sleepers",
                     track.gauge),
         {.reads = {"track"}});
  for (std::size_t i = 0; i < model.passage.forces.size(); ++i)
    s.rule(fmt::format("force[{}].side", i), space || model.passage.forces[i].number() == 0,
           "needs two rails (track.dimension = \"space\")", about);
}

void declare_bending(const TrackModel& model, input::Section& s) {
  if (model.line.track.sleeper.model == track::SleeperModel::rigid) return;
  s.rule("ballast.mass", model.line.ballast.mass == 0,
         "must be 0 with track.sleeper.model = \"beam\": the ballast of such sleepers is "
         "distributed along them",
         {.reads = {"track", "ballast"}});
  s.rule("track.sleeper.model", !model.on_bed,
         "must be \"rigid\" on a bed, whose sleepers are those of [sleepers]",
         {.reads = {"track"}});
}

// On a bed a pad would change the contact law of stones and sleeper.
void declare_under_sleeper(const TrackModel& model, input::Section& s) {
  if (model.line.under_sleeper.stiffness == 0) return;
  const input::About about{.reads = {"under_sleeper_pad", "track", "model"}};
  s.rule("under_sleeper_pad.stiffness", !model.on_bed,
         "must be 0 on a bed, where the contact law of stones and sleepers acts ([[contact]])",
         about);
  s.rule("under_sleeper_pad.stiffness", model.line.track.support == track::Support::sleepers,
         "needs sleepers: there are none (track.support)", about);
  s.rule("under_sleeper_pad.stiffness",
         model.line.track.sleeper.model == track::SleeperModel::rigid,
         "must be 0 with track.sleeper.model = \"beam\": the ballast of such sleepers is "
         "distributed along them",
         about);
}

// Uplift is possible only for pads on the sleepers of a track alone.
void declare_uplift(const TrackModel& model, input::Section& s) {
  if (!model.line.pad.uplift) return;
  const input::About about{.reads = {"pad", "track", "passage", "model"}};
  s.rule("pad.uplift", !model.on_bed, "must be false on a bed, where pads can transmit tension",
         about);
  s.rule("pad.uplift", model.line.track.support == track::Support::sleepers,
         "needs pads: there are none without sleepers (track.support)", about);
  const auto& zones = model.line.track.zones;
  const auto hangs = [](const track::TrackZone& zone) { return zone.gap > 0; };
  s.rule("pad.uplift", std::none_of(zones.begin(), zones.end(), hangs),
         "must be false with hanging sleepers (gap of a zone): pads must connect these sleepers to "
         "the rail",
         about);
  s.rule(
      "pad.uplift", !by_seats(model),
      "needs a rail, but seat loads act in place of rail and train (passage.loaded_by = \"seats\")",
      about);
}

void declare_flat(const TrackModel& model, input::Section& s) {
  if (model.wheel_rail.flat_axle == 0) return;
  const std::optional<track::Train> train = train_of(model);
  if (!train) return;
  const auto axles = static_cast<std::int64_t>(train->wheels().size());
  s.rule("wheel_rail.flat_axle", model.wheel_rail.flat_axle <= axles,
         fmt::format("must be at most the number of axles of the train, {}", axles),
         {.reads = {"wheel_rail", "train", "vehicle"}});
  if (model.wheel_rail.flat_axle > axles) return;
  const auto wheel = static_cast<std::size_t>(model.wheel_rail.flat_axle - 1);
  s.rule("wheel_rail.flat_axle", train->wheels()[wheel].unknown >= 0,
         "is an axle of constant force, which does not roll: its flat has no effect",
         {.severity = input::Severity::warning, .reads = {"wheel_rail", "train", "vehicle"}});
}

// A run of a given duration may end before its train has arrived.
void declare_arrival(const TrackModel& model, input::Section& s) {
  const double lasts = model.passage.duration;
  if (model.train.vehicles.empty() || lasts == 0 || !model.train.changes_are_valid()) return;
  const double reached = track::Motion(model.train).x(lasts);
  s.rule("train.start", reached >= 0,
         fmt::format("the train does not reach the track: its first axle is at {:.4g} m at the "
                     "end of the run ({:g} s, passage.duration)",
                     reached, lasts),
         {.severity = input::Severity::warning, .reads = {"train", "passage.duration"}});
}

// A train with zero speed never leaves the track, and never arrives on a bed.
void declare_speed(const TrackModel& model, input::Section& s) {
  const std::vector<double>& later = model.train.speeds;
  const bool goes = model.train.speed > 0 ||
                    std::any_of(later.begin(), later.end(), [](double v) { return v > 0; });
  const bool ends = !model.on_bed && model.passage.duration > 0;
  s.rule("train.speed", goes || ends,
         model.on_bed
             ? "the train does not move: train.speed or one of train.speeds must be above 0 m/s"
             : "the train does not move: train.speed or one of train.speeds must be above 0 m/s, "
               "or passage.duration above 0 s",
         {.reads = {"train", "passage.duration"}});
}

// Rules for positions and times of the run of a track alone.
void declare_run(const TrackModel& model, input::Section& s) {
  const TrackOutput& passage = model.passage;
  const double length = model.line.track.length;
  for (const double x : passage.points)
    s.rule("passage.points", x <= length,
           fmt::format("{:g} m is beyond the track, which is {:g} m long; give points on the "
                       "track, or [] for none",
                       x, length),
           {.reads = {"passage.points", "track.length"}});
  s.rule("train.start", model.train.vehicles.empty() || model.train.start < length,
         fmt::format("is beyond the track, which is {:g} m long", length),
         {.reads = {"train.start", "train.vehicles", "track.length"}});
  declare_arrival(model, s);
  const std::optional<double> stop = model.stop();
  s.rule("passage.duration", passage.duration > 0 || !stop,
         fmt::format("must be above 0 s: the train stops with its first axle at {:g} m and never "
                     "leaves the track (train.speeds)",
                     stop.value_or(0)),
         {.reads = {"passage.duration", "train", "vehicle", "track.length"}});
  s.rule("passage.duration", passage.duration == 0 || passage.duration >= passage.step,
         "is shorter than a time step (passage.step): the run takes one whole step",
         {.severity = input::Severity::warning, .reads = {"passage"}});
}

}  // namespace

void TrackOutput::declare(input::Section& s) {
  PassageParameters::declare(s);
  s.numbers("points", points, {.unit = "m", .at_least = 0},
            "x of the rail points in the histories, each with the nearest sleeper.");
}

void TrackModel::declare_train_and_contact(input::Section& s) {
  auto fixed = s.fixed_by(input::state::train);
  s.table("track", line.track, "The track as a whole.");
  s.tables("vehicle", vehicles, "A vehicle in addition to those of the library.");
  s.table("train", train, "Vehicles and their motion.");
  fixed.end();
  s.table("wheel_rail", wheel_rail, "Contact of wheels and rail.");
  const auto fixed_content = s.fixed_by(input::state::content_with_train);
  s.table("irregularity", irregularity, "Irregularity of the rail's running surface.");
  s.table("irregularity_right", irregularity_right,
          "Irregularity of the right rail, if it differs from that of the left.");
}

// For model = "track", and for a bed with a train, which has another run and other histories.
void TrackModel::declare(input::Section& s) {
  // Irregularities, the contact and the step may change while a train is under way.
  auto fixed = s.fixed_by(input::state::train);
  {
    const auto fixed_rail = s.fixed_by(input::state::solid_rails);
    s.table("rail", line.rail, "Properties of one rail.");
  }
  s.table("pad", line.pad, "Rail pads.");
  s.table("ballast", line.ballast,
          "Ballast springs of a track alone or on a ground, and before and beyond a bed.");
  fixed.end();
  s.table("under_sleeper_pad", line.under_sleeper,
          "Pads below the sleepers of a track alone or on a ground.");
  declare_train_and_contact(s);
  s.tables("force", passage.forces,
           "A force on the rail of a track alone or on a ground, in addition to a train.");
  s.table("passage", passage,
          "The run of a track alone or on a ground; on a bed only step and tolerance are used.");
  declare_size(*this, s);
  declare_vehicles(*this, s);
  declare_unused_vehicles(*this, s);
  declare_tipping(*this, s);
  declare_speed(*this, s);
  declare_forces(*this, s);
  declare_sides(*this, s);
  declare_bending(*this, s);
  declare_under_sleeper(*this, s);
  declare_uplift(*this, s);
  if (!on_bed) s.table("load", load, "Loads on rail seats instead of a train.");
  declare_seats(*this, s);
  declare_flat(*this, s);
  declare_idle(*this, s);
  if (is_countable()) declare_track_rules(*this, s);
  if (!on_bed) declare_run(*this, s);
}

std::optional<track::Train> train_of(const TrackModel& model) {
  try {
    return track::Train(model.train, model.vehicles, 1);
  } catch (const InputError&) {
    return {};
  }
}

// A run without a duration ends when the last axle has left, that of a bed with its stage.
std::optional<Range> range_of_wheels(const TrackModel& model) {
  const std::optional<track::Train> train = train_of(model);
  if (!train || !model.train.changes_are_valid()) return {};
  constexpr double far = std::numeric_limits<double>::infinity();
  double nearest = far, furthest = -far;  // m behind the first axle
  for (const track::Train::Wheel& wheel : train->wheels())
    if (wheel.unknown >= 0)
      nearest = std::min(nearest, wheel.behind), furthest = std::max(furthest, wheel.behind);
  if (nearest > furthest) return {};
  const double lasts = model.on_bed ? 0 : model.passage.duration;
  const double reached = lasts > 0 ? track::Motion(model.train).x(lasts) : far;
  return Range{model.train.start - furthest, reached - nearest};
}

std::optional<double> TrackModel::stop() const {
  if (!train.changes_are_valid() || train.speeds.empty()) return {};
  const std::optional<track::Train> whole = train_of(*this);
  const track::Motion motion(train);
  if (!whole || std::isfinite(motion.time_at(line.track.length + whole->axle_distance())))
    return {};
  return motion.x(train.times.back());
}

bool TrackModel::is_countable() const { return elements_of(line.track) <= most_elements; }

std::size_t TrackModel::sleepers() const { return line.track.sleepers(); }

std::optional<track::SeatLoad> seats_of(const TrackModel& model) {
  if (!by_seats(model)) return {};
  return track::SeatLoad(model.load, model.line.track.spacing, model.sleepers());
}

// The comparison as text includes every parameter.
std::vector<std::string> TrackModel::given_sections() const {
  const auto values = [](TrackModel model) {
    return input::values_of(input::effective([&model](input::Section& s) { model.declare(s); }));
  };
  TrackModel none;
  none.on_bed = on_bed, none.on_ground = on_ground;
  const input::Values usual = values(none);
  std::vector<std::string> sections;
  for (const auto& [key, value] : values(*this)) {
    const auto other = usual.find(key);
    const std::string section = key.substr(0, key.find_first_of(".["));
    if (other != usual.end() && other->second == value) continue;
    if (sections.empty() || sections.back() != section) sections.push_back(section);
  }
  return sections;
}

}  // namespace trackbed::model
