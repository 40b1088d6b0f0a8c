// The track as one linear structure: a rail on a Kelvin bed, or on pads, sleepers and ballast.
// Vertical motion in the plane of one rail, or of two rails on sleepers that roll. Values of pads
// and ballast are those of one rail seat; a plane track has half a sleeper. Upwards is positive,
// the left side (number 0) is at positive y, and roll is positive if the left side is higher.
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

// none: the rail is supported at its ends only, as a bridge is.
enum class Support { sleepers, continuous, none };
enum class RailEnds { free, pinned };
enum class ZoneSide { both, left, right };

struct PadParameters {
  double stiffness = 120e6, damping = 25e3;  // N/m, N s/m, of one rail seat
  double bilinear_at = 0;                    // m of compression; 0: linear
  double bilinear_stiffness = 0;             // N/m, beyond that compression
  bool uplift = false;                       // compression only: the rail can lift off
  double preload = -1;                       // N, lost before lift-off; below 0: the rail's weight
  void declare(input::Section& s);
};

// Under one rail seat: a Kelvin spring, or two with a ballast mass between (Zhai et al. 2004).
struct BallastParameters {
  double stiffness = 60e6, damping = 60e3;              // N/m, N s/m
  double mass = 0;                                      // kg; 0: none, and nothing below
  double below_stiffness = 80e6, below_damping = 30e3;  // N/m, N s/m
  void declare(input::Section& s);
};

// Below sleepers, in series with the ballast spring.
struct UnderSleeperPadParameters {
  double stiffness = 0, damping = 0;  // N/m, N s/m, below one rail seat; stiffness 0: none
  double from = 0, to = 0;            // m, range with pads; to 0: up to the track's end
  // Whether the sleeper at x of a track of `length` m has a pad.
  bool lie_at(double x, double length) const;
  void declare(input::Section& s);
};

// A part of the track with other properties.
struct TrackZone {
  double from = 0, to = 0;         // m
  double rail = 1, bed = 1;        // factors of E I, k G A and mass; of bed or ballast
  double pad = 1, sleeper = 1;     // factors of rail pads; of mass and roll inertia of sleepers
  double under_sleeper_pad = 1;    // factor of under-sleeper pads
  double footprint = 1;            // factor of the width of footprints on a ground
  double spacing = 0;              // m, of its sleepers; 0: that of the track
  double gap = 0;                  // m, between sleepers and ballast of the unloaded track
  ZoneSide side = ZoneSide::both;  // of a track with two rails
  // Whether from <= x < to, or x is the end of the track of `length` m and of the zone.
  bool covers(double x, std::size_t of_side, double length) const;
  void declare(input::Section& s);
};

enum class SleeperModel { rigid, beam };

// Properties of a sleeper modelled as a beam of constant rectangular cross-section.
struct SleeperBeamParameters {
  SleeperModel model = SleeperModel::rigid;
  BeamTheory theory = BeamTheory::timoshenko;
  double young = 35e9, poisson = 0.2;  // Pa, -
  double width = 0.26, height = 0.2;   // m
  std::int64_t elements = 8;           // between the rails
  double unsupported = 0;              // m, length in the middle without ballast below
  void declare(input::Section& s);
};

// A part of the track in which sleepers have the same spacing, with one at each end.
struct EvenPart {
  double from, to;     // m
  std::int64_t count;  // of spacings
  double spacing() const { return (to - from) / static_cast<double>(count); }
};

struct TrackParameters {
  Dimension dimension = Dimension::plane;  // space: both rails, bodies roll
  Support support = Support::sleepers;
  RailEnds ends = RailEnds::pinned;
  std::int64_t rails = 2;       // identical, each carries an equal part of vehicles and sleepers
  double length = 60;           // m, from x = 0
  double spacing = 0.6;         // m, of sleepers
  std::int64_t elements = 4;    // in a spacing
  double sleeper_mass = 300;    // kg, whole
  double gauge = 1.5;           // m, between the rails' centrelines, space or bending sleepers
  double sleeper_length = 2.6;  // m, space or bending sleepers
  double sleeper_inertia = 0;   // kg m^2, roll, space, rigid; 0: of a uniform bar
  SleeperBeamParameters sleeper = {};
  double bed_stiffness = 50e6;  // N/m^2, continuous
  double bed_damping = 50e3;    // N s/m^2, continuous
  double run_in = 6;            // m, at both ends
  double run_in_factor = 100;   // of all stiffness and damping at the ends of the track
  std::vector<TrackZone> zones;
  // m, between the rails on which wheels roll; 0: one rail.
  double wheel_gauge() const { return dimension == Dimension::space ? gauge : 0; }
  // Along the whole track; zones with a spacing of their own are parts.
  std::vector<EvenPart> even_parts() const;
  std::size_t sleepers() const;
  // m, of sleeper n from the start of the track; beyond its end at the usual spacing.
  double sleeper_x(std::size_t n) const;
  double least_spacing() const;  // m
  // m, largest gap of the zones at x, m.
  double gap(double x, std::size_t side) const;
  // Product of this factor of all zones at x, m.
  double factor(double TrackZone::*of, double x, std::size_t side) const;
  // m, lateral distance of the ballast springs from the middle of the track; one rail: 0.
  double bearing_arm() const;
  void declare(input::Section& s);
  void declare_space(input::Section& s);
  void declare_sleepers(input::Section& s);
  void declare_spacings(input::Section& s);
};

// Hz, first bending frequency of a free sleeper, Euler-Bernoulli theory.
double bending_frequency(const TrackParameters& track);

// The part whose motion is prescribed by another model: sleepers, or the ground below the ballast.
enum class MovedPart { sleepers, ground };

struct LineParameters {
  RailParameters rail;
  PadParameters pad;
  BallastParameters ballast;
  UnderSleeperPadParameters under_sleeper;
  TrackParameters track;
  // `moved` sleepers, from number `first_moved` on, or the ground below their ballast, have a
  // motion that another model prescribes; not parameters of a deck. The moved part and all below it
  // are not in the line, which ends with the pads or the ballast above.
  std::size_t first_moved = 0, moved = 0;
  MovedPart moves = MovedPart::sleepers;
  // Factor of the pads of each moved sleeper: the pad forces are this matrix times those that
  // `pad` gives for the compressions; empty: the factors of the zones. On one rail only the first
  // entry is used.
  std::vector<Matrix2> moved_pads = {};
  bool pads = true;  // false: seat loads act on the sleepers, and the rail is unloaded
};

// Prescribed height and velocity of a moved sleeper or of the ground below it: m and m/s, upwards.
struct Seat {
  double height = 0, rate = 0;
};

// A point of the rail: its deflection is sum value_k u[unknown_k] plus `local` times a force there.
// Beyond the ends the rail is rigid: no unknowns, no flexibility. An unknown of -1 is fixed.
struct RailPoint {
  std::array<std::int32_t, 4> unknown{-1, -1, -1, -1};
  std::array<double, 4> value{};
  double local = 0;  // m/N
  double deflection(const Vector& u) const;
  void add(double force, Vector& to) const;  // N upwards
};

// A unilateral (compression-only) spring with a gap: ballast below a hanging sleeper, or the
// additional stiffness of a bilinear pad. approach = deflection(u) - gap, m. The damper force is
// limited to the spring force, so that the force starts at zero.
// `in_matrix`: a pad that lifts off after it has lost its preload (a gap below 0). The line's
// matrices contain its spring and damper, which also act in tension; the stop is the correction to
// them, which is zero while the pad is compressed.
struct Stop {
  RailPoint point;
  double gap, stiffness, damping;  // m, N/m, N s/m
  std::int32_t seat = -1;          // number of a moved seat, whose height adds to the approach
  bool in_matrix = false;
  double force(double approach, double rate) const;
  // N/m; rate_slope: derivative of the rate with respect to the approach, 1/s.
  double slope(double approach, double rate, double rate_slope) const;
  double energy(double approach) const;  // J, of its spring, in addition to that of the matrices
};

// Unknowns of the rails at a node: w and theta of the left one, then of the right one; -1: fixed,
// or no such rail.
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
  // Unknown of its height below a rail; -1: a moved sleeper.
  std::int32_t sleeper_unknown(std::size_t i, std::size_t side = 0) const;
  bool sleepers_bend() const;
  double gauge() const;  // m
  // Point of sleeper i, which must not be a moved one, y m to the left of its middle.
  RailPoint sleeper_at(std::size_t i, double y) const;
  // N m, bending moment of a sleeper at its node nearest to y (rails and middle are nodes),
  // positive if its ends bend upwards. From element forces, see bending_moment.
  double sleeper_moment(std::size_t i, double y, const Vector& u) const;
  std::size_t first_moved() const;  // see LineParameters
  std::size_t moved() const;
  MovedPart moves() const;
  // Number of moved seats; on two rails the left seat of each sleeper comes before the right one.
  std::size_t seats() const;
  std::size_t nearest_sleeper(double x) const;
  // N, of the pad on sleeper i, compression positive. `seats`: motion of a moved sleeper, left
  // before right.
  double seat_force(std::size_t i, const Vector& u, const Vector& v,
                    const std::array<Seat, 2>& seats = {}, std::size_t side = 0) const;
  // N, force of the ballast of sleeper i on the ground, on two rails at that end, compression
  // positive; without the force of the stop if there is a gap. 0 for bending sleepers with a gap.
  double ground_force(std::size_t i, const Vector& u, const Vector& v, const Seat& seat,
                      std::size_t side = 0) const;
  std::int32_t ground_stop(std::size_t i, std::size_t side = 0) const;  // stop number; -1: none
  std::array<double, 2> ground_spring(std::size_t i, std::size_t side = 0) const;  // N/m, N s/m
  // Adds the forces (N) that the motion of the seats causes through the pads of moved sleepers, or
  // through the ballast on moved ground.
  void add_seats(const std::vector<Seat>& seats, Vector& to) const;
  // N m, bending moment of the rail just left of x, which should be a node; sagging is positive.
  // From element forces, which include the consistent forces of a bed.
  double bending_moment(double x, const Vector& u, std::size_t side = 0) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace trackbed::track
