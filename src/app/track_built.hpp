// A track as it is built from its parameters, alone or on a ground; inside of track runs.
#pragma once

#include <optional>
#include <string>

#include "app/ground_below.hpp"
#include "app/parameters.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::app {

// The model built from its parameters. Members stand in the order they need each other: the passage
// keeps references to line and train.
struct Built {
  Built(const TrackModel& m, const track::LineParameters& l)
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
  std::optional<track::Irregularity> right;  // if it is another one
  track::Passage passage;
};

// The ground below the track of a model that has one, and the track with the step both take.
struct Together {
  Together(const par::Comm& comm, const Model& model);

  std::optional<GroundBelow> below;
  TrackModel track;
  track::LineParameters line;
};

// A line on the screen. Rank 0.
void say(const par::Comm& comm, const std::string& line);
// What a user checks first: is this the model that was meant? Returns the warnings it says. Throws
// InputError if nothing will happen. Collective.
std::vector<std::string> introduce(const par::Comm& comm, const Model& model, const Together& whole,
                                   const Built& built);

}  // namespace trackbed::app
