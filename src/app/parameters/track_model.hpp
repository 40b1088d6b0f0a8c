// Parameters of a deck with model = "track": a train on a rail with springs and dampers as
// supports, without stones and ground.
#pragma once

#include <optional>
#include <vector>

#include "trackbed/input/section.hpp"
#include "trackbed/track/passage.hpp"

namespace trackbed::app {

// Output of a passage.
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
  track::SeatLoadParameters load;  // of a track alone that is loaded by seat loads
  TrackOutput passage;
  bool on_bed = false;     // the run is that of a bed
  bool on_ground = false;  // the ground may divide its steps
  void declare(input::Section& s);
  bool is_countable() const;     // whether the number of rail elements is feasible
  std::size_t sleepers() const;  // of the track
  // m, where the first axle finally stops if the last one is then still on the track.
  std::optional<double> stop() const;
  // Whether every parameter has its default.
  bool untouched() const;
};

// None if it cannot be built; the reason is reported by rules.
std::optional<track::Train> train_of(const TrackModel& model);
// Range of x, m.
struct Range {
  double from, to;
};
// From the last wheel that rolls, at the start of the run, to the first one at its end; none if no
// wheel rolls.
std::optional<Range> range_of_wheels(const TrackModel& model);

// None unless the track has seat loads. Reads the file of a table; throws InputError for a bad one.
std::optional<track::SeatLoad> seats_of(const TrackModel& model);

}  // namespace trackbed::app
