// What a deck with model = "track" says: a train on a rail, its supports given as springs and
// dampers, without stones and ground.
#pragma once

#include <optional>
#include <vector>

#include "trackbed/input/section.hpp"
#include "trackbed/track/passage.hpp"

namespace trackbed::app {

// What of a passage is written.
struct TrackOutput : track::PassageParameters {
  double history_interval = 1e-3;       // s
  std::vector<double> points = {30.0};  // m
  double checkpoint_interval = 0;       // s; 0: none
  double wall_time = 0;                 // s; 0: no limit
  std::int64_t stop_after = 0;          // steps; 0: no limit
  void declare(input::Section& s);
};

struct TrackModel {
  track::LineParameters line;
  std::vector<track::VehicleParameters> vehicles;
  track::TrainParameters train;
  track::WheelRailParameters wheel_rail;
  track::IrregularityParameters irregularity;  // of the left rail, or of both
  track::IrregularityParameters irregularity_right{.kind = track::IrregularityKind::same};
  track::SeatLoadParameters load;  // of a track alone, if it is loaded by seats
  TrackOutput passage;
  bool on_bed = false;     // the run is that of a bed
  bool on_ground = false;  // whose steps the ground may divide
  void declare(input::Section& s);
  bool is_countable() const;     // whether the rail has elements that a machine can hold
  std::size_t sleepers() const;  // of the track
  // m, where the first axle comes to rest for ever if the last one is then still on the track.
  std::optional<double> stop() const;
  // Whether every parameter has its default.
  bool untouched() const;
};

// None that cannot be built: what it lacks is a problem of its own.
std::optional<track::Train> train_of(const TrackModel& model);
// From the hindmost wheel that rolls at the begin of the run to the foremost one at its end, m;
// none if none rolls.
struct Way {
  double from, to;
};
std::optional<Way> way_of_wheels(const TrackModel& model);

// None unless it is loaded by seats. Reads the file of a table; throws InputError for a bad one.
std::optional<track::SeatLoad> seats_of(const TrackModel& model);

}  // namespace trackbed::app
