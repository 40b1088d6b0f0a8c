// A train on a rail that rests partly on sleepers somebody else moves (those on stones), partly on
// sleepers on springs before and behind them. Every rank computes all of it alike.
//
// Two frames: x of the track counts from its begin, as in all parameters of rail and train; x of
// the bed is that of the model around it. Both point along the track.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "trackbed/io/file.hpp"
#include "trackbed/track/passage.hpp"

namespace trackbed::track {

// How the rail rests on the sleepers of a bed.
struct SeatParameters {
  std::int64_t before = 20;  // sleepers on springs before the first of the bed
  double rails = 1;          // whose load the sleepers of the model carry; on two rails 2
  void declare(input::Section& s);
};

// What a train on a bed is made of; looked at while it is built only.
struct TrainOnBedParameters {
  const LineParameters& line;
  const std::vector<VehicleParameters>& vehicles;
  const TrainParameters& train;
  const WheelRailParameters& wheel_rail;
  const IrregularityParameters& irregularity;
  const SeatParameters& seat;
  std::size_t sleepers;      // of the bed
  double first;              // m, x of the bed, of the first of them
  double step;               // s
  double tolerance = 1e-12;  // m, see PassageParameters
  // m/s per N, of each sleeper's seats at the end of a step by forces of its pads there; their
  // levels give way by half a step of that. On one rail the first entry alone. Of sleepers in
  // implicit steps; none: explicit ones, for which forces of the end of a step come too late.
  std::vector<Matrix2> mobility = {};
  // Of the right rail, if it is another one; its kind is not `same`.
  std::optional<IrregularityParameters> irregularity_right = {};
};

// On two rails each sleeper of the bed has two seats, left before right wherever they are listed.
class TrainOnBed {
 public:
  // The rail is laid on the sleepers as they stand: at `levels`, m, one for each seat. Throws
  // InputError for unknown vehicles and bad files.
  TrainOnBed(const TrainOnBedParameters& parameters, const std::vector<double>& levels);
  ~TrainOnBed();
  TrainOnBed(TrainOnBed&&) noexcept;

  // N, downwards, on the i-th sleeper of the bed at the present time; of all rails it carries.
  double seat_force(std::size_t i) const;
  // The same of one seat: on one rail all of it.
  double seat_force(std::size_t i, std::size_t side) const;
  // One step: to `levels` (m) and `rates` (m/s, up) of the bed's seats; with `mobility` to those
  // without pads, whose forces `seat_force` then is. RunError: contacts of wheels are not solved.
  void advance(const std::vector<double>& levels, const std::vector<double>& rates);
  // The same train once more, on the rail as it is.
  void send_again();

  const Train& train() const;
  const Line& line() const;
  const Passage& passage() const;
  // m, of one seat since the rail was laid; with what `mobility` adds.
  double seat_displacement(std::size_t i, std::size_t side) const;
  double wheel_x(std::size_t i) const;  // m, x of the bed
  // m, above the i-th sleeper of the bed, since laid.
  double rail_displacement(std::size_t i, std::size_t side = 0) const;

  // All ranks hold the same state; rank 0 of `comm` writes it, all read it. Collective.
  void save(io::File& file, const std::string& group, const par::Comm& comm) const;
  void load(const io::File& file, const std::string& group);

 private:
  struct Room;
  std::unique_ptr<Room> room_;
};

}  // namespace trackbed::track
