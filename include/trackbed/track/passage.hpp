// A train on a track, in time: wheels, rail and everything on springs, coupled by the contact of
// each wheel. Small enough that every rank computes all of it alike, so that no bit depends on the
// number of ranks.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "trackbed/input/section.hpp"
#include "trackbed/io/file.hpp"
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
  double tolerance = 1e-12;            // m, of the approach of wheel and rail
  std::vector<RailForce> forces = {};  // a section of its own
  LoadedBy loaded_by = LoadedBy::train;
  void declare(input::Section& s);
};

class Passage {
 public:
  // `right`: of the right rail, if it is another one than of the left. `seats`: loads on each seat
  // of a line without pads. Keeps references to `line` and `train`; they outlive it. Begins in
  // static equilibrium, the train moving at its speed. Throws RunError if there is none.
  Passage(const Line& line, const Train& train, const WheelRail& law,
          const Irregularity& irregularity, const TrainParameters& motion,
          const PassageParameters& parameters, const std::optional<Irregularity>& right = {},
          const std::optional<SeatLoad>& seats = {});
  ~Passage();
  Passage(Passage&&) noexcept;

  // One step. Throws RunError if the contact cannot be solved or something is no number.
  void advance();
  // How the sleepers, or the ground, that somebody else moves stand at the end of the next step; on
  // two rails left before right of each. Until it is called: where they were when the rail was
  // laid.
  void place_seats(const std::vector<Seat>& seats);
  // Of a ground that gives way to the forces of the end of a step: each column of `give` is what a
  // force at one seat lowers all of them by in a step, m/N, rates following by average acceleration
  // as on the track. From then on `place_seats` says how the ground stands under `forces` of the
  // ballast (N, downwards, as `ground_force`), and the step finds forces and ground that fit each
  // other.
  void found_on(const Eigen::MatrixXd& give);
  void place_seats(const std::vector<Seat>& seats, const Vector& forces);
  // N, of the pad on the i-th of them; compression positive.
  double seat_force(std::size_t i, std::size_t side = 0) const;
  const Seat& seat(std::size_t i, std::size_t side = 0) const;  // as it was placed last
  // N, on sleeper i of those on springs, by its pad or as a seat load; downwards positive.
  double on_sleeper(std::size_t i, std::size_t side = 0) const;
  // Of sleeper i, on two rails of that end: N, downwards, on the ground below its ballast, and how
  // that stands; at the present time. The ground is at rest unless it is moved.
  double ground_force(std::size_t i, std::size_t side = 0) const;
  Seat ground_below(std::size_t i, std::size_t side = 0) const;
  // Puts the train back to its start, at rest as at the begin, on a rail that goes on as it is. For
  // trains that start on rigid rails.
  void send_again();

  // All ranks hold the same state; rank 0 of `comm` writes it, all read it. Collective.
  void save(io::File& file, const std::string& group, const par::Comm& comm) const;
  // Throws RunError for the state of another track or train.
  void load(const io::File& file, const std::string& group);

  double time() const;                       // s
  double duration() const;                   // s, as asked for or until the last axle has left
  double wheel_x(std::size_t i) const;       // m
  double wheel_force(std::size_t i) const;   // N, on the rail, of one wheel
  double wheel_height(std::size_t i) const;  // m, of a wheel; 0 for a constant force
  double rail_displacement(double x, std::size_t side = 0) const;  // m, upwards
  double rail_force(std::size_t i) const;  // N, downwards, of the i-th of the forces
  // J, kinetic and elastic, of rail, sleepers and all springs below them, stops among them; of
  // springs on what is moved, all but stops, as if it stood at 0.
  double track_energy() const;
  const Line& line() const;
  const Newmark& line_motion() const;
  const Newmark& train_motion() const;
  std::int64_t iterations() const;  // Newton steps so far
  std::int64_t steps() const;       // since the train was sent
  std::int64_t lost() const;        // steps of wheels, on the track, that had left the rail

 private:
  struct Room;
  std::unique_ptr<Room> room_;
};

}  // namespace trackbed::track
