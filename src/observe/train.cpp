// Histories of wheels, rail and vehicles of a train over a bed, with the names used for a track
// alone.
#include <limits>

#include "observe/impl.hpp"
#include "trackbed/track/vehicle_layout.hpp"

namespace trackbed::observe {

namespace {

// Order of the columns below.
struct TrainColumn {
  enum : std::size_t {
    wheel_force,
    wheel_x,
    rail_displacement,
    body_displacement,
    body_motion,
    body_roll,
    seat_displacement,
    seat_force
  };
};

// The last ones for two rails only.
std::vector<Column> train_columns(const TrainInstant& train, std::size_t sleepers) {
  const std::size_t seats = sleepers * train.rails;
  std::vector<Column> columns{
      {"history/wheel/force", {"N", "of one wheel on the rail, down positive"}, train.wheels},
      {"history/wheel/x", {"m", "position in the coordinates of the bed"}, train.wheels},
      {"history/rail/displacement",
       {"m", "vertical, above each seat of the bed, since the rail was laid"},
       seats},
      {"history/body/displacement",
       {"m", "vertical, up positive, relative to unloaded springs; 0 for vehicles of kind forces"},
       train.bodies},
      {"history/body/acceleration", {"m/s2", "vertical, no filter"}, train.bodies}};
  if (train.rails == 1) return columns;
  columns.insert(
      columns.end(),
      {{"history/body/roll",
        {"rad", "left side up positive; 0 for vehicles of kind forces"},
        train.bodies},
       {"history/seat/displacement",
        {"m", "vertical, of each rail seat, since the rail was laid"},
        seats},
       {"history/seat/force", {"N", "pad force on each rail seat, down positive"}, seats}});
  return columns;
}

// Left before right of each sleeper; requires `running`.
void add_seats(const TrainInstant& instant, std::size_t sleepers, std::vector<Column>& to) {
  const track::TrainOnBed& on_bed = *instant.running;
  for (std::size_t i = 0; i < sleepers; ++i)
    for (std::size_t side = 0; side < instant.rails; ++side) {
      to[TrainColumn::rail_displacement].values.push_back(on_bed.rail_displacement(i, side));
      if (instant.rails == 1) continue;
      to[TrainColumn::seat_displacement].values.push_back(on_bed.seat_displacement(i, side));
      to[TrainColumn::seat_force].values.push_back(on_bed.seat_force(i, side));
    }
}

}  // namespace

// NaN while there is no train, since zero would be a valid position and force.
void Results::Impl::sample_train(const TrainInstant& instant, std::size_t sleepers) {
  if (train.empty()) train = train_columns(instant, sleepers);
  if (!instant.running) {
    for (Column& column : train)
      column.values.insert(column.values.end(), column.width,
                           std::numeric_limits<double>::quiet_NaN());
    return;
  }
  const track::TrainOnBed& on_bed = *instant.running;
  for (std::size_t i = 0; i < instant.wheels; ++i) {
    train[TrainColumn::wheel_force].values.push_back(on_bed.passage().wheel_force(i));
    train[TrainColumn::wheel_x].values.push_back(on_bed.wheel_x(i));
  }
  add_seats(instant, sleepers, train);
  const track::Newmark& motion = on_bed.passage().train_motion();
  for (std::size_t i = 0; i < instant.bodies; ++i) {
    const bool forces = track::layout_of(on_bed.train().vehicles()[i].kind).constant;
    const std::int32_t body = on_bed.train().first_unknown()[i];
    train[TrainColumn::body_displacement].values.push_back(forces ? 0 : motion.displacement[body]);
    train[TrainColumn::body_motion].values.push_back(forces ? 0 : motion.acceleration[body]);
    if (instant.rails == 1) continue;
    const std::int32_t roll = on_bed.train().roll_unknown()[i];
    train[TrainColumn::body_roll].values.push_back(roll < 0 ? 0 : motion.displacement[roll]);
  }
}

}  // namespace trackbed::observe
