// A track built from its parameters, alone or on a ground; internal to track runs.
#pragma once

#include <optional>
#include <string>

#include "model/coupling/ground_below.hpp"
#include "trackbed/model/parameters.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::model {

// The model built from its parameters. Members are in the order of dependence: the passage keeps
// references to line and train.
struct BuiltTrack {
  BuiltTrack(const TrackModel& m, const track::LineParameters& l)
      : line(l),
        train(m.train, m.vehicles, m.line.track.rails, m.line.track.wheel_gauge()),
        law(m.wheel_rail),
        irregularity(m.irregularity, m.line.track.length),
        right(right_of(m)),
        passage(line, train, law, irregularity, m.train, m.passage, right, seats_of(m)) {}

  static std::optional<track::Irregularity> right_of(const TrackModel& m) {
    if (m.irregularity_right.kind == track::IrregularityKind::same) return {};
    return track::Irregularity(m.irregularity_right, m.line.track.length);
  }

  track::Line line;
  track::Train train;
  track::WheelRail law;
  track::Irregularity irregularity;
  std::optional<track::Irregularity> right;  // if it differs from `irregularity`
  track::Passage passage;
};

// The track, and the ground below it if the model has one, with the step of both.
struct TrackAssembly {
  TrackAssembly(const par::Comm& comm, const Model& model);

  std::optional<GroundBelow> below;
  TrackModel track;
  track::LineParameters line;
};

// Prints the main properties of the model, to check that it is the intended one. Returns the
// warnings that it prints. Throws InputError if the duration is zero. Collective.
std::vector<std::string> introduce(const par::Comm& comm, const Model& model,
                                   const TrackAssembly& whole, const BuiltTrack& built);

}  // namespace trackbed::model
