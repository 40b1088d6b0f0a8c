// Dynamics of a train on a track: vehicles and track are coupled by the contact of each wheel with
// the rail. Every rank computes all of it identically, so that results are bitwise identical on any
// number of ranks.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "trackbed/input/section.hpp"
#include "trackbed/io/archive.hpp"
#include "trackbed/track/forces.hpp"
#include "trackbed/track/irregularity.hpp"
#include "trackbed/track/line.hpp"
#include "trackbed/track/newmark.hpp"
#include "trackbed/track/seat_load.hpp"
#include "trackbed/track/train.hpp"
#include "trackbed/track/wheel_rail.hpp"

namespace trackbed::track {

// seats: loads on the rail seats instead of rail, pads and train.
enum class LoadedBy { train, seats };

struct PassageParameters {
  double step = 2e-4;                  // s
  double duration = 0;                 // s; 0: until the last axle has left the track
  double tolerance = 1e-12;            // m, convergence of the approach of wheel and rail
  std::vector<RailForce> forces = {};  // a section of its own
  LoadedBy loaded_by = LoadedBy::train;
  void declare(input::Section& s);
};

class Passage {
 public:
  // `right`: irregularity of the right rail if it differs from that of the left one. `seats`: loads
  // on each seat of a line without pads. Keeps references to `line` and `train`, which must outlive
  // it. Starts in static equilibrium, with the train at its speed. Throws RunError if there is
  // none.
  Passage(const Line& line, const Train& train, const WheelRail& law,
          const Irregularity& irregularity, const TrainParameters& motion,
          const PassageParameters& parameters, const std::optional<Irregularity>& right = {},
          const std::optional<SeatLoad>& seats = {});
  ~Passage();
  Passage(Passage&&) noexcept;

  // One step. Throws RunError if the contacts do not converge or a value is not finite.
  void advance();
  // Prescribes height and velocity of the moved sleepers, or of the moved ground, at the end of the
  // next step; on two rails left before right of each. Before the first call they are those at
  // which the rail was placed.
  void place_seats(const std::vector<Seat>& seats);
  // Couples the track implicitly to a ground with the given compliance: column j is the lowering of
  // all seats within a step due to a unit force at seat j at its end, m/N; velocities follow by
  // average acceleration as on the track. From then on `place_seats` gives the motion of the ground
  // under the ballast forces `forces` (N, downwards, as `ground_force`), and the step solves for
  // ballast forces and ground motion together.
  void set_ground_compliance(const Eigen::MatrixXd& compliance);
  void place_seats(const std::vector<Seat>& seats, const Vector& forces);
  // N, of the pad on the i-th moved sleeper; compression positive.
  double seat_force(std::size_t i, std::size_t side = 0) const;
  const Seat& seat(std::size_t i, std::size_t side = 0) const;  // as last placed
  // N, on sleeper i of those on springs, by its pad or as a seat load; downwards positive.
  double on_sleeper(std::size_t i, std::size_t side = 0) const;
  // Of sleeper i, on two rails of that end, at the present time: N, downwards, on the ground below
  // its ballast; height and velocity of that ground, which is fixed unless it is moved.
  double ground_force(std::size_t i, std::size_t side = 0) const;
  Seat ground_below(std::size_t i, std::size_t side = 0) const;
  // Puts the train back to its start position in static equilibrium; the state of the rail is kept.
  // For trains that start on rigid rails.
  void restart_train();

  void archive(io::Archive& a);

  double time() const;                       // s
  double duration() const;                   // s, as given or until the last axle has left
  double wheel_x(std::size_t i) const;       // m
  double wheel_force(std::size_t i) const;   // N, on the rail, of one wheel
  double wheel_height(std::size_t i) const;  // m, of a wheel; 0 for a constant force
  double rail_displacement(double x, std::size_t side = 0) const;  // m, upwards
  double rail_force(std::size_t i) const;  // N, downwards, of the i-th of the forces
  // J, kinetic and elastic, of rail, sleepers and all springs below them, including stops; springs
  // on moved parts count with a seat height of 0, stops with the true one.
  double track_energy() const;
  const Line& line() const;
  const Newmark& line_motion() const;
  const Newmark& train_motion() const;
  std::int64_t iterations() const;  // of Newton's method up to now
  std::int64_t steps() const;       // since the train started
  std::int64_t lost() const;        // steps times wheels without contact, on the track

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trackbed::track
