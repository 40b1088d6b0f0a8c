// Private data of Passage: its state between steps and the data computed in each step.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "track/passage/influence.hpp"
#include "trackbed/track/motion.hpp"
#include "trackbed/track/passage.hpp"

namespace trackbed::track {

constexpr int most_iterations = 100;  // of the contact forces of a step or of equilibrium

using Matrix = Eigen::MatrixXd;

// The state is listed once, in passage_file.cpp; all else follows from the deck or from the state.
struct Passage::Impl {
  Impl(const Line& line, const Train& train, const WheelRail& law,
       const std::array<Irregularity, 2>& irregularity, const TrainParameters& motion,
       const PassageParameters& parameters, const std::optional<SeatLoad>& seats);

  double x(std::size_t wheel) const { return motion.x(time()) - train.wheels()[wheel].behind; }
  double time() const { return static_cast<double>(steps) * parameters.step; }
  void place_wheels();
  void reset_train();
  void load_seats();
  Columns columns_of(std::size_t first, std::size_t count) const;
  Matrix rail_matrix(std::size_t first, const Columns& columns) const;
  void renew_flexibility();
  void start();
  void step();
  void solve_contacts(const Vector& without);
  Vector newton_step(const Vector& without) const;
  Vector contact_load(const Vector& force) const;
  Vector approaches(const Vector& of_track, const Vector& of_train) const;
  double wheel_height(const Train::Wheel& wheel, const Vector& of_train) const;
  Vector ballast_forces(const Vector& u, const Vector& v, const std::vector<Seat>& on) const;
  void set_ground_compliance(const Matrix& compliance);
  void project_ground(std::size_t from, std::size_t to);
  void add_ground_to_flexibility();
  void move_seats(const Vector& increment, Vector& of_track);
  void move_seats_without_contacts(Vector& of_track);
  void move_seats_by_contacts(const Vector& contact_forces, Vector& of_track);
  double iterate_equilibrium(Vector& u, const Matrix& g, const Vector& without);
  Seat prescribed(Eigen::Index stop) const;
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
  // Contacts are rolling wheels, then stops. For each wheel a column: its force on the train's
  // unknowns, and their increment in a step. stop_change: increments of the track due to stops,
  // which do not move along the track.
  Columns wheel_columns, wheel_change;
  Columns stop_change;
  Influence influence;           // between wheels
  Matrix flexibility;            // m/N, A of passage.cpp: approaches per contact forces, in a step
  std::vector<RailPoint> point;  // below each wheel, at the end of the step
  std::vector<RailPoint> touching;  // of each contact
  Vector approach;                  // m, of each contact
  Vector stop_before, stop_rate;    // m, m/s, of stops without the seats, at the start of the step
  double rate_slope = 0;            // 1/s, derivative of rate by approach: 2/h, static: 0
  Vector constant_load;             // N on the track's unknowns
  std::vector<Seat> seats;          // of moved sleepers, at the end of the step
  // A ground that is coupled implicitly, see passage_ground.cpp.
  struct Ground {
    Vector forces;        // N, of the ballast, under which the seats have their prescribed motion
    Columns columns;      // Z, m of the track's unknowns per m of each seat
    Matrix compliance;    // G, m/N
    Matrix contact_rows;  // R', m of each contact's approach per m of each seat
  };
  std::optional<Ground> ground;
  Vector train_at_rest;   // m, static equilibrium at the start
  Vector wheels_at_rest;  // m, approaches in static equilibrium
  std::int64_t steps = 0, iterations = 0, lost = 0;
};

}  // namespace trackbed::track
