// The track as one linear structure: a rail on a Kelvin bed, or on pads, sleepers and ballast.
// Vertical motion in the plane of one rail, or of two rails on sleepers that roll. Pad and ballast
// are those of one rail seat; a plane track has half a sleeper. Upwards is positive, the left side
// (number 0) lies at positive y, and roll is positive where the left side is higher.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "trackbed/core/types.hpp"
#include "trackbed/input/section.hpp"
#include "trackbed/track/rail.hpp"

namespace trackbed::track {

using Sparse = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;
using Matrix2 = Eigen::Matrix2d;  // of the left and the right seat of a sleeper

// M a + C v + K u = f; kg, N s/m, N/m and the like for rotations.
struct LinearSystem {
  Sparse mass, damping, stiffness;
};

// none: the rail hangs at its ends, as a bridge does.
enum class Support { sleepers, continuous, none };
enum class RailEnds { free, pinned };
enum class ZoneSide { both, left, right };

struct PadParameters {
  double stiffness = 120e6, damping = 25e3;  // N/m, N s/m, of one rail seat
  double knee = 0;                           // m of compression; 0: linear
  double beyond = 0;                         // N/m, stiffness beyond the knee
  bool uplift = false;                       // they only push: the rail rises from them
  double preload = -1;                       // N, what is lifted first; below 0: the rail's weight
  void declare(input::Section& s);
};

// Under one rail seat: a Kelvin spring, or two with a ballast mass between (Zhai et al. 2004).
struct BallastParameters {
  double stiffness = 60e6, damping = 60e3;              // N/m, N s/m
  double mass = 0;                                      // kg; 0: none, and nothing below
  double below_stiffness = 80e6, below_damping = 30e3;  // N/m, N s/m
  void declare(input::Section& s);
};

// Below sleepers, in series with the spring of the ballast under them.
struct UnderSleeperPadParameters {
  double stiffness = 0, damping = 0;  // N/m, N s/m, below one rail seat; stiffness 0: none
  double from = 0, to = 0;            // m, where sleepers have them; to 0: up to the track's end
  // A sleeper at x of a track of `length` m.
  bool lie_at(double x, double length) const;
  void declare(input::Section& s);
};

// Where the track differs from the rest.
struct TrackZone {
  double from = 0, to = 0;         // m
  double rail = 1, bed = 1;        // factors of E I, k G A and mass; of bed or ballast
  double gap = 0;                  // m, between sleepers and ballast while nothing is on the track
  ZoneSide side = ZoneSide::both;  // of a track with two rails
  // Of a track of `length` m: from <= x < to, or up to its end.
  bool covers(double x, std::size_t of_side, double length) const;
  void declare(input::Section& s);
};

enum class SleeperModel { rigid, beam };

// What a sleeper that bends is made of: a rectangle, alike all along.
struct SleeperBeamParameters {
  SleeperModel model = SleeperModel::rigid;
  BeamTheory theory = BeamTheory::timoshenko;
  double young = 35e9, poisson = 0.2;  // Pa, -
  double width = 0.26, height = 0.2;   // m
  std::int64_t elements = 8;           // between the rails
  double unsupported = 0;              // m, of its middle, without ballast below
  void declare(input::Section& s);
};

struct TrackParameters {
  Dimension dimension = Dimension::plane;  // space: both rails, bodies roll
  Support support = Support::sleepers;
  RailEnds ends = RailEnds::pinned;
  std::int64_t rails = 2;       // alike, sharing vehicles and sleepers evenly
  double length = 60;           // m, from x = 0
  double spacing = 0.6;         // m, of sleepers
  std::int64_t elements = 4;    // in a spacing
  double sleeper_mass = 300;    // kg, whole
  double gauge = 1.5;           // m, between the rails' middles, space or sleepers that bend
  double sleeper_length = 2.6;  // m, as the gauge
  double sleeper_inertia = 0;   // kg m^2, roll, space, rigid; 0: of a uniform bar
  SleeperBeamParameters sleeper = {};
  double bed_stiffness = 50e6;  // N/m^2, continuous
  double bed_damping = 50e3;    // N s/m^2, continuous
  double run_in = 6;            // m, at both ends
  double run_in_factor = 100;   // of all stiffness and damping at the very end
  std::vector<TrackZone> zones;
  // m, between the rails that wheels roll on; 0: one rail.
  double wheel_gauge() const { return dimension == Dimension::space ? gauge : 0; }
  double bearing_arm() const;  // m, ballast springs of two rails beside the middle; of one: 0
  void declare(input::Section& s);
  void declare_space(input::Section& s);
  void declare_sleepers(input::Section& s);
};

// Hz, the first of a sleeper that nothing holds, as Euler and Bernoulli have it.
double bending_frequency(const TrackParameters& track);

// What somebody else moves: sleepers, or the ground below the ballast of sleepers.
enum class MovedPart { sleepers, ground };

struct LineParameters {
  RailParameters rail;
  PadParameters pad;
  BallastParameters ballast;
  UnderSleeperPadParameters under_sleeper;
  TrackParameters track;
  // So many sleepers, from this number on, are moved by somebody else, or the ground below their
  // ballast is; no parameters of a deck. What moves and what is below it is not in the line: of
  // pads or ballast it has the upper ends.
  std::size_t first_moved = 0, moved = 0;
  MovedPart moves = MovedPart::sleepers;
  // Of each sleeper that is moved, a factor of its pads: their forces are this times those by their
  // compressions; none: 1. On one rail the first entry alone.
  std::vector<Matrix2> moved_pads = {};
  bool pads = true;  // false: sleepers are loaded by seat loads, and the rail by nothing
};

// How a sleeper that somebody else moves, or the ground below it, stands: m and m/s, upwards.
struct Seat {
  double height = 0, rate = 0;
};

// A point of the rail: its deflection is sum value_k u[unknown_k] plus `local` times a force there.
// Beyond the ends the rail is rigid: no unknowns, no flexibility. An unknown of -1 is held.
struct RailPoint {
  std::array<std::int32_t, 4> unknown{-1, -1, -1, -1};
  std::array<double, 4> value{};
  double local = 0;  // m/N
  double deflection(const Vector& u) const;
  void add(double force, Vector& to) const;  // N upwards
};

// A spring that only pushes, and only once its point has given way by more than the gap: ballast
// below a hanging sleeper, the part of a pad beyond its knee. approach = deflection(u) - gap, m.
// The damper adds or takes at most what the spring has, so that the force begins at zero.
// `in_matrix`: of a pad that lifts off, once it has given back what presses it at rest (a gap below
// 0). The line's matrices have its spring and damper, which also pull; the stop is what has to be
// added to them, nothing while the pad is pressed.
struct Stop {
  RailPoint point;
  double gap, stiffness, damping;  // m, N/m, N s/m
  std::int32_t seat = -1;          // number of one moved by somebody else: its height adds
  bool in_matrix = false;
  double force(double approach, double rate) const;
  // N/m; rate_slope: what a metre of approach changes in the rate, 1/s.
  double slope(double approach, double rate, double rate_slope) const;
  double energy(double approach) const;  // J, what its spring adds to those of the matrices
};

// Unknowns of the rails at a node: w and theta of the left one, then of the right one; -1: held, or
// no such rail.
using RailNodes = std::array<std::int32_t, 4>;

class Line {
 public:
  explicit Line(const LineParameters& parameters);
  ~Line();
  Line(Line&&) noexcept;

  const LinearSystem& system() const;
  double length() const;      // m
  std::size_t sides() const;  // rails: 1 or 2
  RailPoint at(double x, std::size_t side = 0) const;
  std::vector<RailNodes> rail_nodes() const;  // from x = 0 on
  const std::vector<Stop>& stops() const;     // not part of `system`
  std::size_t sleepers() const;               // 0 unless supported by sleepers
  double sleeper_x(std::size_t i) const;
  // Its height below a rail; -1: moved by somebody else.
  std::int32_t sleeper_unknown(std::size_t i, std::size_t side = 0) const;
  bool sleepers_bend() const;
  double gauge() const;  // m
  // Of sleeper i, which nobody else moves, y m to the left of its middle.
  RailPoint sleeper_at(std::size_t i, double y) const;
  // N m in a sleeper that bends, at its node nearest to y (rails and middle are nodes), positive
  // where its ends are bent upwards. From element forces, see bending_moment.
  double sleeper_moment(std::size_t i, double y, const Vector& u) const;
  std::size_t first_moved() const;  // see LineParameters
  std::size_t moved() const;
  MovedPart moves() const;
  std::size_t seats() const;  // of all that are moved: on two rails left before right of each
  std::size_t nearest_sleeper(double x) const;
  // N, of the pad on sleeper i, compression positive. `seats`: of a sleeper that is moved, left
  // before right.
  double seat_force(std::size_t i, const Vector& u, const Vector& v,
                    const std::array<Seat, 2>& seats = {}, std::size_t side = 0) const;
  // N, of the ballast of sleeper i, on two rails of that end, on the ground, compression positive;
  // of an end that hangs without what its stop does. None of beams that hang.
  double ground_force(std::size_t i, const Vector& u, const Vector& v, const Seat& seat,
                      std::size_t side = 0) const;
  std::int32_t ground_stop(std::size_t i, std::size_t side = 0) const;  // its number; -1: none
  std::array<double, 2> ground_spring(std::size_t i, std::size_t side = 0) const;  // N/m, N s/m
  // Adds what pads of moved sleepers, or ballast on moved ground, do besides holding, N.
  void add_seats(const std::vector<Seat>& seats, Vector& to) const;
  // N m in the rail just left of x, which should be a node; positive where it is bent upwards
  // (sagging). From element forces, so that a bed's share is in it.
  double bending_moment(double x, const Vector& u, std::size_t side = 0) const;

 private:
  struct Room;
  std::unique_ptr<Room> room_;
};

}  // namespace trackbed::track
