// A train on a rail whose sleepers are in part moved by another model (those on stones), in part
// supported by springs, before and behind the bed. Every rank computes all of it identically.
//
// Two frames: x of the track is measured from its start, as in all parameters of rail and train; x
// of the bed is that of the surrounding model. Both point along the track.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "trackbed/io/archive.hpp"
#include "trackbed/track/passage.hpp"

namespace trackbed::track {

// Support of the rail by the sleepers of a bed.
struct SeatParameters {
  std::int64_t before = 20;  // sleepers on springs before the first sleeper of the bed
  double rails = 1;          // number of rails carried by the model's sleepers; on two rails 2
  void declare(input::Section& s);
};

// Input of a train on a bed; used during construction only.
struct TrainOnBedParameters {
  const LineParameters& line;
  const std::vector<VehicleParameters>& vehicles;
  const TrainParameters& train;
  const WheelRailParameters& wheel_rail;
  const IrregularityParameters& irregularity;
  const SeatParameters& seat;
  std::size_t sleepers;      // of the bed
  double first;              // m, x of the bed, of the first sleeper
  double step;               // s
  double tolerance = 1e-12;  // m, see PassageParameters
  // m/s per N, velocity of each sleeper's seats at the end of a step due to pad forces at that
  // time; their heights change by half a step times this. On one rail only the first entry is used.
  // For sleepers with implicit steps; empty: explicit steps, which use the pad forces at their
  // start.
  std::vector<Matrix2> mobility = {};
  // Irregularity of the right rail if it differs; its kind is not `same`.
  std::optional<IrregularityParameters> irregularity_right = {};
  // `levels_without_load` of an earlier train, whose rail is kept. Its pads take up their forces
  // within `ramp`, s, as the sleepers may have settled without it. Empty: a rail is laid on them.
  std::vector<double> kept = {};
  double ramp = 0;
};

// On two rails each sleeper of the bed has two seats, left before right wherever they are listed.
class TrainOnBed {
 public:
  // The rail is placed on the sleepers at their present heights `levels`, m, one for each seat;
  // above sleepers in a zone with a gap it lies higher by it. A rail that is kept takes its place
  // gradually. Throws InputError for unknown vehicles and invalid files, RunError if there is no
  // static equilibrium.
  TrainOnBed(const TrainOnBedParameters& parameters, const std::vector<double>& levels);
  ~TrainOnBed();
  TrainOnBed(TrainOnBed&&) noexcept;

  // N, downwards, on the i-th sleeper of the bed at the present time; sum of all rails on it.
  double seat_force(std::size_t i) const;
  // The same for one seat: on one rail all of it.
  double seat_force(std::size_t i, std::size_t side) const;
  // One step to heights `levels` (m) and velocities `rates` (m/s, up) of the bed's seats; with
  // `mobility` these are the values without pad forces, and `seat_force` returns the pad forces at
  // the end of the step. Throws RunError if the wheel contacts do not converge.
  void advance(const std::vector<double>& levels, const std::vector<double>& rates);
  // Starts the same train again; the state of the rail is kept.
  void restart_train();

  const Train& train() const;
  const Line& line() const;
  const Passage& passage() const;
  // m, of each seat, at which its pad carries no load: where the sleepers were when the rail was
  // placed, and gaps above them.
  const std::vector<double>& levels_without_load() const;
  // m, of the highest seat at rest, on which an even rail lies.
  double highest_seat() const;
  // m, of one seat since the rail was placed, including the contribution of `mobility`.
  double seat_displacement(std::size_t i, std::size_t side) const;
  double origin() const;                // m, x of the bed at the start of the track
  double wheel_x(std::size_t i) const;  // m, x of the bed
  // m, above the i-th sleeper of the bed, since the rail was placed.
  double rail_displacement(std::size_t i, std::size_t side = 0) const;

  void archive(io::Archive& a);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trackbed::track
