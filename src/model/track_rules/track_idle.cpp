// Parameters without effect because of another one, as one table: parts that the track does not
// have (a second rail, sleepers, sleepers that bend), and parts that seat loads replace.
#include <fmt/format.h>

#include <algorithm>

#include "model/track_rules/track_rules.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::model {

namespace {

// Features of the track on which parameters depend: without the feature they have no effect. On a
// bed solid rails may use parameters that a beam does not.
struct Features {
  bool two_rails, bends, sleepers, continuous, supported, run_in, rail, shears, vehicles, rolls;
};

Features features_of(const TrackModel& model) {
  const track::TrackParameters& track = model.line.track;
  const std::optional<track::Train> train = train_of(model);  // none: reported elsewhere
  return {.two_rails = track.dimension == Dimension::space,
          .bends = track.sleeper.model == track::SleeperModel::beam,
          .sleepers = model.on_bed || track.support == track::Support::sleepers,
          .continuous = track.support == track::Support::continuous,
          .supported = model.on_bed || track.support != track::Support::none,
          .run_in = track.run_in > 0,
          .rail = model.passage.loaded_by == track::LoadedBy::train,
          .shears = model.on_bed || model.line.rail.theory == track::BeamTheory::timoshenko,
          .vehicles = !model.train.vehicles.empty(),
          .rolls = !train || std::any_of(train->wheels().begin(), train->wheels().end(),
                                         [](const auto& wheel) { return wheel.unknown >= 0; })};
}

constexpr const char* one_rail = "there is one rail (track.dimension)";
constexpr const char* no_sleepers = "there are no sleepers (track.support)";
constexpr const char* rigid = "sleepers are rigid (track.sleeper.model)";
constexpr const char* no_bed = "the rail has no continuous support (track.support)";
constexpr const char* no_run_in = "there is no run-in (track.run_in)";
constexpr const char* bridge =
    "a rail that is supported only at its ends has no run-in (track.support)";
constexpr const char* stiff = "the rail is rigid in shear (rail.theory)";
constexpr const char* no_rail = "seat loads replace rail and train (passage.loaded_by)";
constexpr const char* no_vehicles = "there are no vehicles (train.vehicles)";
constexpr const char* no_wheels = "axles of constant force do not roll (train.vehicles)";

// Warns of `key` if it is given but has no effect.
struct Idle {
  input::Section& s;
  void operator()(const std::string& key, bool given, bool acts, const char* why) const {
    s.rule(key, acts || !given, fmt::format("has no effect: {}", why),
           {.severity = input::Severity::warning,
            .reads = {"track", "train", "vehicle", "passage.loaded_by",
                      key.substr(0, key.find('.'))}});
  }
};

void declare_idle_sections(const TrackModel& model, const Features& acts, const Idle& idle) {
  const bool pad = input::differs_from_default(model.line.pad),
             ballast = input::differs_from_default(model.line.ballast);
  idle("pad", pad, acts.sleepers, no_sleepers);
  idle("pad", pad && acts.sleepers, acts.rail, no_rail);
  idle("ballast", ballast, acts.sleepers, no_sleepers);
  idle("rail", input::differs_from_default(model.line.rail), acts.rail, no_rail);
  const track::RailParameters &rail = model.line.rail, none;
  idle("rail.poisson", rail.poisson != none.poisson, acts.shears, stiff);
  idle("rail.shear_factor", rail.shear_factor != none.shear_factor, acts.shears, stiff);
  const bool rolls = acts.rail && acts.rolls;
  const char* why = !acts.rail ? no_rail : acts.vehicles ? no_wheels : no_vehicles;
  idle("wheel_rail", input::differs_from_default(model.wheel_rail), rolls, why);
  for (const auto& [key, one] : {std::pair{"irregularity.kind", model.irregularity.kind},
                                 {"irregularity_right.kind", model.irregularity_right.kind}})
    idle(key, one != track::IrregularityKind::none && one != track::IrregularityKind::same, rolls,
         why);
}

// Parameters of [track], each with the feature on which it depends.
void declare_idle_track(const track::TrackParameters& track, const Features& acts,
                        const Idle& idle) {
  const track::TrackParameters none;
  const auto number = [&](const char* key, auto track::TrackParameters::*of, bool where,
                          const char* why) {
    idle(std::string("track.") + key, track.*of != none.*of, where, why);
  };
  using Track = track::TrackParameters;
  const bool across = acts.sleepers && (acts.two_rails || acts.bends);
  const char* why = acts.sleepers ? one_rail : no_sleepers;
  number("gauge", &Track::gauge, acts.two_rails || across, one_rail);
  number("sleeper_length", &Track::sleeper_length, across, why);
  number("sleeper_inertia", &Track::sleeper_inertia, across, why);
  number("sleeper_mass", &Track::sleeper_mass, acts.sleepers, no_sleepers);
  number("bed_stiffness", &Track::bed_stiffness, acts.continuous, no_bed);
  number("bed_damping", &Track::bed_damping, acts.continuous, no_bed);
  // 0 is correct without run-in.
  idle("track.run_in", track.run_in != none.run_in && track.run_in > 0, acts.supported, bridge);
  number("run_in_factor", &Track::run_in_factor, acts.run_in && acts.supported,
         acts.supported ? no_run_in : bridge);
}

void declare_idle_sleeper(const track::SleeperBeamParameters& sleeper, const Features& acts,
                          const Idle& idle) {
  const track::SleeperBeamParameters none;
  const auto number = [&](const char* key, auto track::SleeperBeamParameters::*of) {
    idle(std::string("track.sleeper.") + key, sleeper.*of != none.*of, acts.bends, rigid);
  };
  using Sleeper = track::SleeperBeamParameters;
  number("theory", &Sleeper::theory), number("young", &Sleeper::young);
  number("poisson", &Sleeper::poisson), number("width", &Sleeper::width);
  number("height", &Sleeper::height), number("elements", &Sleeper::elements);
}

void declare_idle_vehicle(const track::VehicleParameters& vehicle, const std::string& name,
                          const Features& acts, const Idle& idle) {
  using Vehicle = track::VehicleParameters;
  constexpr std::pair<const char*, double Vehicle::*> rolls[] = {
      {"body_roll", &Vehicle::body_roll},           {"bogie_roll", &Vehicle::bogie_roll},
      {"wheelset_roll", &Vehicle::wheelset_roll},   {"primary_base", &Vehicle::primary_base},
      {"secondary_base", &Vehicle::secondary_base}, {"body_offset", &Vehicle::body_offset}};
  for (const auto& [key, of] : rolls)
    idle(fmt::format("{}.{}", name, key), vehicle.*of != 0, acts.two_rails, one_rail);
}

void declare_idle_train(const track::TrainParameters& train, const Features& acts,
                        const Idle& idle) {
  const track::TrainParameters none;
  const bool runs = acts.rail && acts.vehicles;
  const char* why = acts.rail ? no_vehicles : no_rail;
  idle("train.speed", train.speed != none.speed, runs, why);
  idle("train.start", train.start != none.start, runs, why);
  idle("train.times", !train.times.empty(), runs, why);
}

}  // namespace

void declare_idle(const TrackModel& model, input::Section& s) {
  const Features acts = features_of(model);
  const Idle idle{s};
  declare_idle_sections(model, acts, idle);
  declare_idle_track(model.line.track, acts, idle);
  declare_idle_sleeper(model.line.track.sleeper, acts, idle);
  for (std::size_t i = 0; i < model.vehicles.size(); ++i)
    declare_idle_vehicle(model.vehicles[i], fmt::format("vehicle[{}]", i), acts, idle);
  declare_idle_train(model.train, acts, idle);
}

}  // namespace trackbed::model
