// Private data of Line: unknowns, supports and the triplets of its matrices.
#pragma once

#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "track/line/beam.hpp"
#include "track/line/sleeper_beam.hpp"
#include "trackbed/track/line.hpp"

namespace trackbed::track {

// A spring and a damper in parallel; elongation sum value_k u[unknown_k], -1 is the fixed ground.
struct Kelvin {
  std::array<std::int32_t, 3> unknown{-1, -1, -1};
  std::array<double, 3> value{};
  double stiffness = 0, damping = 0;  // N/m, N s/m
};

using RailNode = std::array<std::int32_t, 2>;  // unknowns of w and theta

// A plane track has only the left side.
struct Sleeper {
  double x;
  std::array<std::int32_t, 2> unknown{-1, -1};  // heights below the rails
  // Unknowns of the lower face of an under-sleeper pad and of the ballast mass; -1: none.
  std::array<std::int32_t, 2> pad_below{-1, -1}, ballast{-1, -1};
  std::array<Kelvin, 2> pad;
  // N/m, N s/m: coupling of the force of each pad to the compression of the other one.
  double across_stiffness = 0, across_damping = 0;
  std::array<double, 2> additional{};  // N/m, additional stiffness of bilinear pads
  std::array<Kelvin, 2> lowest{};      // on the ground
  // Upper end of `lowest`: its height is the sum of these unknowns times their factors.
  std::array<std::vector<std::pair<std::int32_t, double>>, 2> on{};
  std::array<std::int32_t, 2> stop{-1, -1};  // number of the stop below an end with a gap
  std::vector<RailNode> across = {};         // of a bending sleeper, left end first
};

using Triplets = std::vector<Eigen::Triplet<double>>;

struct Line::Impl {
  explicit Impl(const LineParameters& given);
  void number();
  void assemble();
  void assemble_element(std::size_t e, std::size_t side);
  void add_element(const std::array<std::int32_t, 4>& unknown, const Matrix4& m, const Matrix4& c,
                   const Matrix4& k);
  void connect(const Kelvin& element);
  void add_sleeper(std::size_t index);
  void add_pad(std::size_t index, std::size_t side);
  void join_pads(std::size_t index);
  void add_sleeper_mass(const Sleeper& sleeper);
  void add_pad_below(std::size_t index, std::size_t side);
  void add_ballast(std::size_t index, std::size_t side);
  void add_gap(std::size_t index, std::size_t side, const Kelvin& bed);
  Kelvin bed_below(const Sleeper& sleeper, std::size_t side) const;
  Kelvin under(const Sleeper& sleeper, std::size_t side, const Kelvin& one) const;
  // Bending sleepers.
  void number_across(Sleeper& sleeper);
  void add_across(std::size_t index);
  void add_gap_across(std::size_t index, std::size_t e);
  void add_ground_across(std::size_t index, std::size_t side);
  std::array<double, 2> ground_shape_across(std::size_t e, std::size_t side) const;
  BeamElement across_element(const Sleeper& sleeper, std::size_t e) const;
  std::array<std::int32_t, 4> unknowns_across(const Sleeper& sleeper, std::size_t e) const;
  std::array<double, 2> bed_across(const Sleeper& sleeper, std::size_t e) const;
  double middle(std::size_t e) const { return node_x[e] + element_length[e] / 2; }  // m
  std::size_t element_at(double x) const;
  double run_in(double x) const;
  Matrix2 pad_factors(std::size_t index) const;
  double preload(std::size_t index, std::size_t side) const;
  double zone_factor(double TrackZone::*of, double x, std::size_t side = 0) const {
    return parameters.track.factor(of, x, side);
  }
  double rail_factor(std::size_t e, std::size_t side) const;
  double bed_factor(double x, std::size_t side) const;
  BeamElement element(std::size_t e, std::size_t side) const;
  std::array<std::int32_t, 4> unknowns_of(std::size_t e, std::size_t side) const;
  bool has_sleeper(std::size_t node) const;
  bool is_of(MovedPart part, std::size_t sleeper) const {
    return parameters.moves == part && sleeper >= parameters.first_moved &&
           sleeper - parameters.first_moved < parameters.moved;
  }
  bool is_moved(std::size_t sleeper) const { return is_of(MovedPart::sleepers, sleeper); }

  LineParameters parameters;
  Beam beam;
  std::size_t sides;
  std::optional<SleeperMesh> mesh;             // of bending sleepers
  std::size_t elements = 0;                    // of a rail
  std::vector<double> node_x, element_length;  // m, of a rail
  std::array<std::vector<RailNode>, 2> nodes;  // of each side
  std::vector<Sleeper> sleepers;
  std::int32_t unknowns = 0;
  Triplets mass, damping, stiffness;
  LinearSystem system;
  std::vector<Stop> stops;
};

}  // namespace trackbed::track
