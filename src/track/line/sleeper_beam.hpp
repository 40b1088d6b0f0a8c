// A sleeper as a beam across the track: its mesh and beam properties.
#pragma once

#include <array>
#include <vector>

#include "track/line/beam.hpp"
#include "trackbed/track/line.hpp"

namespace trackbed::track {

// From the left end to the right one, or to the middle in a plane track (symmetry).
struct SleeperMesh {
  explicit SleeperMesh(const TrackParameters& track);
  std::size_t elements() const { return from_end.size() - 1; }
  double length(std::size_t e) const { return from_end[e + 1] - from_end[e]; }  // m
  // Number of the element at `s` m from the left end.
  std::size_t element_at(double s) const;
  std::size_t nearest_node(double s) const;
  // Half of the sleeper: 0 below the left rail, 1 below the right one.
  std::size_t side(std::size_t e) const { return 2 * from_end[e] < whole * (1 - 1e-9) ? 0 : 1; }
  // Part of an element on ballast (from, to: relative to its length); none if both are equal.
  std::array<double, 2> on_ballast(std::size_t e) const;

  double whole;                       // m, of the sleeper
  double ballast;                     // m, length of each half on ballast
  std::vector<double> from_end;       // m, of each node
  std::array<std::size_t, 2> seat{};  // nodes below the rails; of a half only the first
};

Beam sleeper_beam(const TrackParameters& track);

}  // namespace trackbed::track
