// Parameters of rail, track and train: alone on springs and dampers, on a ground, or on a bed.
#pragma once

#include <optional>
#include <vector>

#include "trackbed/input/section.hpp"
#include "trackbed/track/passage.hpp"

namespace trackbed::model {

// A passage, and the points of the rail in its histories.
struct TrackOutput : track::PassageParameters {
  std::vector<double> points = {30.0};  // m
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
  // Names of the sections in which a parameter does not have its default.
  std::vector<std::string> given_sections() const;

 private:
  void declare_train_and_contact(input::Section& s);
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

}  // namespace trackbed::model
