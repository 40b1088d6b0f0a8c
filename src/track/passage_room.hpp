// What a passage keeps between steps, and what it makes anew in each.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "influence.hpp"
#include "trackbed/track/motion.hpp"
#include "trackbed/track/passage.hpp"

namespace trackbed::track {

using Matrix = Eigen::MatrixXd;

// State is listed once, in passage_file.cpp; all else follows from the deck or from state.
struct Passage::Room {
  Room(const Line& line, const Train& train, const WheelRail& law,
       const std::array<Irregularity, 2>& irregularity, const TrainParameters& motion,
       const PassageParameters& parameters, const std::optional<SeatLoad>& seats);

  double x(std::size_t wheel) const { return motion.x(time()) - train.wheels()[wheel].behind; }
  double time() const { return static_cast<double>(steps) * parameters.step; }
  void place_wheels();
  void rest_train();
  void load_seats();
  Columns columns_of(std::size_t first, std::size_t count) const;
  Matrix rail_matrix(std::size_t first, const Columns& columns) const;
  void renew_flexibility();
  void start();
  void step();
  void solve_contacts(const Vector& without);
  Vector newton_step(const Vector& without) const;
  Vector pushed(const Vector& force) const;
  Vector approaches(const Vector& of_track, const Vector& of_train) const;
  double wheel_height(const Train::Wheel& wheel, const Vector& of_train) const;
  Vector ballast_forces(const Vector& u, const Vector& v, const std::vector<Seat>& on) const;
  void found_on(const Matrix& give);
  void see_ground(std::size_t from, std::size_t to);
  void add_ground_to_flexibility();
  void move_seats(const Vector& way, Vector& of_track);
  void settle_seats(Vector& of_track);
  void press_seats(const Vector& contact_forces, Vector& of_track);
  double improve_rest(Vector& u, const Matrix& g, const Vector& without);
  Seat placed(Eigen::Index stop) const;
  double own_approach(Eigen::Index stop) const;
  double own_rate(Eigen::Index stop) const;
  double rate(Eigen::Index stop) const;
  Vector forces() const;
  Vector slopes() const;
  Eigen::Index wheels_rolling() const { return static_cast<Eigen::Index>(rolling.size()); }
  Eigen::Index contacts() const { return approach.size(); }

  const Line& line;
  const Train& train;
  WheelRail law;
  std::array<Irregularity, 2> irregularity;  // of both sides
  Motion motion;
  PassageParameters parameters;
  std::optional<SeatLoad> seat_load;
  Newmark track, vehicles;
  std::vector<std::size_t> rolling;  // wheels of vehicles; the others are constant forces
  // Contacts are wheels that roll, then stops. Of each wheel a column: the train's unknowns per
  // unit of its force, and their change in a step. Changes of the track by stops, which stay where
  // they are.
  Columns wheel_columns, wheel_change;
  Columns stop_change;
  Influence influence;              // of wheels on each other
  Matrix flexibility;               // m/N, approach of each contact per force of each, in a step
  std::vector<RailPoint> point;     // below each wheel, at the end of the step
  std::vector<RailPoint> touching;  // of each contact
  Vector approach;                  // m, of each contact
  Vector stop_before, stop_rate;    // m, m/s, the track's own of stops, at the begin of the step
  double rate_slope = 0;            // 1/s, of the rate per approach: 2/h, at rest 0
  Vector constant_load;             // N on the track's unknowns
  std::vector<Seat> seats;          // of moved sleepers, at the end of the step
  // A ground that gives way to the forces of the step, as passage_ground.cpp has it.
  struct Ground {
    Vector forces;    // N, of the ballast, under which the ground stands as seats say
    Columns columns;  // Z, m of the track's unknowns per m of each seat
    Matrix give;      // G, m/N
    Matrix seen;      // R', m of each contact's approach per m of each seat
  };
  std::optional<Ground> ground;
  Vector train_at_rest;   // m, equilibrium at the start
  Vector wheels_at_rest;  // m, approaches in it
  std::int64_t steps = 0, iterations = 0, lost = 0;
};

}  // namespace trackbed::track
