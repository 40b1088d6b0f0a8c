// The vehicles of a stage with `train = true`: started when it begins, moved in every window,
// removed when it ends.
#pragma once

#include <optional>
#include <vector>

#include "model/coupling/rail_ends.hpp"
#include "model/coupling/wheel_extremes.hpp"
#include "model/scene/world.hpp"
#include "trackbed/core/clock.hpp"
#include "trackbed/model/parameters.hpp"
#include "trackbed/track/on_bed.hpp"

namespace trackbed::model {

// Holds references: world and model must outlive it.
class StageTrain {
 public:
  // Throws InputError for a bad file of the irregularity if any stage has a train.
  StageTrain(World& world, const Model& model);

  double duration() const;  // s until the last axle has left the track
  // `step`: s, the stage's window. The rail is laid on the sleepers as they are; if that of the
  // last train is kept, its pads take up their forces within `ramp`, s.
  void send(double step, RailState rail, double ramp = 0);
  bool there() const { return train_.has_value(); }
  // N downwards on the i-th sleeper in the next window; `move` applies those on solid sleepers.
  double seat_force(std::size_t i) const { return world_.solids ? 0 : train_->seat_force(i); }
  // Distributes `sums`, N downwards on each sleeper, to its seats: on two rails left before right.
  std::vector<double> on_seats(const std::vector<double>& sums) const;
  // To be called after the sleepers have moved in the present window of `clock`; `trains`: number
  // of trains in the stage.
  void move(std::int64_t trains, const Clock& clock);
  void take_away();
  observe::TrainInstant instant() const;

  // Of wheels above the sleepers of the bed and half a spacing beyond, in the last stage with a
  // train.
  const WheelExtremes& wheel_forces() const { return forces_; }

  // Of the rail at the ends of the bed, in the last stage with a train.
  const RailEnds& rail_ends() const { return ends_; }

  // `step`: s, window of the stage. After the sleepers' state.
  void archive(io::Archive& a, double step);

 private:
  std::size_t rails() const;
  std::vector<track::Seat> seats() const;  // of rigid sleepers
  std::vector<double> levels() const;      // m, of the seats
  std::vector<double> rates() const;       // m/s
  void apply_pad_forces();
  void record_wheels();

  World& world_;
  const Model& model_;
  std::optional<track::TrainOnBed> train_;
  // m, of the rail of the last train: heights of the seats without load. Empty while a train runs,
  // which has them, and before the first.
  std::vector<double> rail_;
  WheelExtremes forces_;
  RailEnds ends_;
  double step_ = 0;  // s
  std::size_t wheels_ = 0, bodies_ = 0;
};

}  // namespace trackbed::model
