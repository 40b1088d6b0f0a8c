// Assembly of the track. Unknowns are numbered along x (rail node, then the sleeper and the ballast
// below it), so that the matrices have a small bandwidth and the cost of a solve is linear in the
// length of the track. A bed under the rail is integrated with the shape functions of w
// (consistent), as the rail's mass is.
// Rejected: sleepers as springs of complex stiffness (frequency domain), which cannot follow a
// wheel that lifts off.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "track/line/line_impl.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

// Between two unknowns; -1 is the fixed ground.
Kelvin between(std::int32_t upper, std::int32_t lower, double stiffness, double damping) {
  return {{upper, lower, -1}, {1, -1, 0}, stiffness, damping};
}

// Unilateral counterpart of the element, which acts after the gap has closed.
Stop stop_of(const Kelvin& element, double gap) {
  RailPoint point;
  for (std::size_t k = 0; k < 3; ++k) {
    point.unknown[k] = element.unknown[k];
    point.value[k] = -element.value[k];
  }
  return {point, gap, element.stiffness, element.damping};
}

// Rows and columns of -1 are fixed: they are not stored.
void add(Triplets& to, std::int32_t row, std::int32_t column, double value) {
  if (row >= 0 && column >= 0 && value != 0) to.emplace_back(row, column, value);
}

Sparse matrix_of(const Triplets& entries, std::int32_t unknowns) {
  Sparse matrix(unknowns, unknowns);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

// The parts of the track were checked to be whole numbers of spacings.
Line::Impl::Impl(const LineParameters& given)
    : parameters(given),
      beam(beam_of(given.rail)),
      sides(given.track.dimension == Dimension::space ? 2 : 1) {
  const TrackParameters& track = parameters.track;
  require(track.sleepers() >= 2 && track.elements >= 1, "a track has at least one element");
  require(track.sleepers() >= given.first_moved + given.moved,
          "first_moved + moved must not exceed the number of sleepers");
  if (track.sleeper.model == SleeperModel::beam) mesh.emplace(track);
  require(!mesh || (given.ballast.mass == 0 && (sides == 2 || track.rails == 2)),
          "bending sleepers need ballast.mass = 0, and two sides or track.rails = 2");
  require(!mesh || given.under_sleeper.stiffness == 0, "under-sleeper pads are for rigid sleepers");
  require(given.pads || given.moved == 0 || given.moves == MovedPart::ground,
          "seat loads are for sleepers on springs");
  require(given.moved_pads.empty() || given.pad.bilinear_at == 0,
          "bilinear pads are not for moved sleepers with implicit steps");
  require(!given.pad.uplift || given.moved == 0, "pads with uplift are for a track alone");
  require(!mesh || given.moved == 0 || given.moves == MovedPart::ground,
          "moved sleepers are rigid");
  node_x.push_back(0);
  for (const EvenPart& part : track.even_parts()) {
    const std::int64_t count = part.count * track.elements;
    const double each = (part.to - part.from) / static_cast<double>(count);
    for (std::int64_t e = 1; e <= count; ++e) {
      node_x.push_back(part.from + static_cast<double>(e) * each);
      element_length.push_back(each);
    }
  }
  elements = element_length.size();
  number();
  assemble();
}

// Sleepers are at the first node of each spacing and at the end of the track.
bool Line::Impl::has_sleeper(std::size_t node) const {
  return parameters.track.support == Support::sleepers &&
         node % static_cast<std::size_t>(parameters.track.elements) == 0;
}

// Pinned ends have no unknown for their height but can rotate. Left before right, from top to
// bottom.
void Line::Impl::number() {
  for (std::size_t n = 0; n <= elements; ++n) {
    const bool held = parameters.track.ends == RailEnds::pinned && (n == 0 || n == elements);
    for (std::size_t side = 0; side < sides; ++side) {
      const std::int32_t w = held ? -1 : unknowns++;
      nodes[side].push_back({w, unknowns++});
    }
    if (!has_sleeper(n)) continue;
    Sleeper sleeper{.x = node_x[n], .unknown = {-1, -1}, .pad = {}};
    if (mesh)
      number_across(sleeper);
    else if (!is_moved(sleepers.size())) {
      const bool pads = parameters.under_sleeper.lie_at(sleeper.x, parameters.track.length);
      const auto count = [&](std::array<std::int32_t, 2>& of) {
        for (std::size_t side = 0; side < sides; ++side) of[side] = unknowns++;
      };
      count(sleeper.unknown);
      if (pads) count(sleeper.pad_below);
      if (parameters.ballast.mass > 0) count(sleeper.ballast);
    }
    sleepers.push_back(sleeper);
  }
}

// In the run-in the stiffness of the rail and all springs and dampers increase smoothly, with their
// logarithm following half a cosine:
//   factor = F^((1 + cos(pi d/L))/2),   d the distance from the end, L the run-in, m.
// A wheel then rolls from a rigid rail onto one that is nearly rigid, without a jump. If the rail's
// own stiffness were not increased, the excitation of wheels by the sleepers of the run-in would be
// ten times larger.
// A rail without support is a bridge: it has no run-in.
double Line::Impl::run_in(double x) const {
  const TrackParameters& track = parameters.track;
  if (track.support == Support::none) return 1;
  const double distance = std::min(x, track.length - x);
  if (distance >= track.run_in) return 1;
  const double exponent = (1 + std::cos(std::numbers::pi * distance / track.run_in)) / 2;
  return std::pow(track.run_in_factor, exponent);
}

// Of bed or ballast at x.
double Line::Impl::bed_factor(double x, std::size_t side) const {
  return run_in(x) * zone_factor(&TrackZone::bed, x, side);
}

double Line::Impl::rail_factor(std::size_t e, std::size_t side) const {
  return zone_factor(&TrackZone::rail, middle(e), side);
}

// An element belongs to the zone that contains its middle. Constructed at each call, which is
// simpler than storing one per element and inexpensive.
BeamElement Line::Impl::element(std::size_t e, std::size_t side) const {
  Beam here = beam.times(rail_factor(e, side));
  here.bending_stiffness *= run_in(middle(e));
  here.shear_stiffness *= run_in(middle(e));
  return {here, element_length[e]};
}

std::array<std::int32_t, 4> Line::Impl::unknowns_of(std::size_t e, std::size_t side) const {
  const std::vector<RailNode>& node = nodes[side];
  return {node[e][0], node[e][1], node[e + 1][0], node[e + 1][1]};
}

// Rail and, for continuous support, the bed below it. The bed's dampers are parallel to its springs
// and have the same shape functions.
void Line::Impl::assemble_element(std::size_t e, std::size_t side) {
  const BeamElement rail = element(e, side);
  Matrix4 k = rail.stiffness(), c = Matrix4::Zero();
  const Matrix4 m = rail.mass();
  if (parameters.track.support == Support::continuous) {
    const double factor = bed_factor(middle(e), side);
    k += parameters.track.bed_stiffness * factor * rail.bed();
    c += parameters.track.bed_damping * factor * rail.bed();
  }
  add_element(unknowns_of(e, side), m, c, k);
}

void Line::Impl::add_element(const std::array<std::int32_t, 4>& unknown, const Matrix4& m,
                             const Matrix4& c, const Matrix4& k) {
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      const std::int32_t row = unknown[static_cast<std::size_t>(i)];
      const std::int32_t column = unknown[static_cast<std::size_t>(j)];
      add(mass, row, column, m(i, j));
      add(damping, row, column, c(i, j));
      add(stiffness, row, column, k(i, j));
    }
}

// A spring and a damper in parallel, linear in compression and tension: tension reduces the
// compression by the weight of the track, which is not in the model.
void Line::Impl::connect(const Kelvin& element) {
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) {
      const double both = element.value[a] * element.value[b];
      add(stiffness, element.unknown[a], element.unknown[b], both * element.stiffness);
      add(damping, element.unknown[a], element.unknown[b], both * element.damping);
    }
}

// Factors of the zones, or those of sleepers whose seats move within a step due to the pad forces
// (on_bed.cpp).
Matrix2 Line::Impl::pad_factors(std::size_t index) const {
  if (is_moved(index) && !parameters.moved_pads.empty())
    return parameters.moved_pads.at(index - parameters.first_moved);
  Matrix2 factors = Matrix2::Identity();
  for (std::size_t side = 0; side < sides; ++side) {
    const auto own = static_cast<Eigen::Index>(side);
    factors(own, own) = zone_factor(&TrackZone::pad, sleepers[index].x, side);
  }
  return factors;
}

// N, static force of a pad, relative to which all forces of the line are measured; unless a value
// is given, the rail's weight over half of the bays beside it.
double Line::Impl::preload(std::size_t index, std::size_t side) const {
  if (parameters.pad.preload >= 0) return parameters.pad.preload;
  const auto bay = static_cast<std::size_t>(parameters.track.elements);
  const std::size_t at = index * bay, elements = nodes[side].size() - 1;
  double mass = 0;
  for (std::size_t e = at - std::min(at, bay); e < std::min(at + bay, elements); ++e)
    mass += beam.times(rail_factor(e, side)).mass * element_length[e] / 2;
  return mass * gravity;
}

// Rail node - pad - sleeper. In the run-in the compression at which bilinear pads become stiffer is
// divided by the run-in's factor of the stiffness; zones do not change it.
void Line::Impl::add_pad(std::size_t index, std::size_t side) {
  Sleeper& sleeper = sleepers[index];
  const PadParameters& pad = parameters.pad;
  const std::size_t at = index * static_cast<std::size_t>(parameters.track.elements);
  const std::int32_t rail = nodes[side][at][0], below = sleeper.unknown[side];
  const auto own = static_cast<Eigen::Index>(side);
  const double stiffer = run_in(sleeper.x) * pad_factors(index)(own, own);
  sleeper.pad[side] = between(rail, below, pad.stiffness * stiffer, pad.damping * stiffer);
  connect(sleeper.pad[side]);
  if (pad.uplift) {
    stops.push_back(
        stop_of(sleeper.pad[side], -preload(index, side) / sleeper.pad[side].stiffness));
    stops.back().in_matrix = true;
  }
  if (pad.bilinear_at == 0) return;
  sleeper.additional[side] = (pad.bilinear_stiffness - pad.stiffness) * stiffer;
  stops.push_back(stop_of(between(rail, below, sleeper.additional[side], 0),
                          pad.bilinear_at / run_in(sleeper.x)));
  if (is_moved(index))
    stops.back().seat = static_cast<std::int32_t>((index - parameters.first_moved) * sides + side);
}

// Coupling of both pads: the force of one moves the seat of the other.
void Line::Impl::join_pads(std::size_t index) {
  Sleeper& sleeper = sleepers[index];
  const double across = run_in(sleeper.x) * pad_factors(index)(0, 1);
  sleeper.across_stiffness = parameters.pad.stiffness * across;
  sleeper.across_damping = parameters.pad.damping * across;
  for (std::size_t side = 0; side < 2; ++side) {
    const std::int32_t one = sleeper.pad[side].unknown[0], other = sleeper.pad[1 - side].unknown[0];
    add(stiffness, one, other, sleeper.across_stiffness);
    add(damping, one, other, sleeper.across_damping);
  }
}

// Half a sleeper for one rail. For a whole one, with heights z_l, z_r below its rails,
//   z = (z_l + z_r)/2,   phi = (z_l - z_r)/g:   m z'^2/2 + I phi'^2/2,
// g the gauge, m; I, kg m^2, that of a uniform bar of the sleeper's length unless given.
void Line::Impl::add_sleeper_mass(const Sleeper& sleeper) {
  const TrackParameters& track = parameters.track;
  const auto [left, right] = sleeper.unknown;
  const double heavier = zone_factor(&TrackZone::sleeper, sleeper.x);
  const double whole = heavier * track.sleeper_mass;
  if (sides == 1) return add(mass, left, left, whole / static_cast<double>(track.rails));
  const double roll = track.sleeper_inertia > 0
                          ? heavier * track.sleeper_inertia
                          : whole * track.sleeper_length * track.sleeper_length / 12;
  const double bounce = whole / 4, turn = roll / (track.gauge * track.gauge);
  for (const std::int32_t one : {left, right})
    for (const std::int32_t other : {left, right})
      add(mass, one, other, one == other ? bounce + turn : bounce - turn);
}

// Ballast distributed uniformly from a to b on both sides of a rigid sleeper's middle is equivalent
// to two springs at y = sqrt((a^2 + a b + b^2)/3) from it: the stiffnesses of bounce and roll, k
// and k y^2, are equal; y = L/sqrt(12) for ballast below the whole length L. Gaps act at these
// springs.
double TrackParameters::bearing_arm() const {
  if (dimension == Dimension::plane) return 0;
  const double half = sleeper_length / 2, none = sleeper.unsupported / 2;
  return std::sqrt((half * half + half * none + none * none) / 3);
}

// A point at y has the height z_l (1/2 + y/g) + z_r (1/2 - y/g). `one` is connected to the unknown
// of one side only.
Kelvin Line::Impl::under(const Sleeper& sleeper, std::size_t side, const Kelvin& one) const {
  if (sides == 1) return one;
  const double aside = parameters.track.bearing_arm() / parameters.track.gauge;
  return {{one.unknown[0], sleeper.unknown[1 - side], one.unknown[1]},
          {0.5 + aside, 0.5 - aside, -1},
          one.stiffness,
          one.damping};
}

// Ballast below the sleeper, or below its under-sleeper pad, whose lower face is an unknown.
Kelvin Line::Impl::bed_below(const Sleeper& sleeper, std::size_t side) const {
  const double factor = bed_factor(sleeper.x, side);
  const double stiffness = parameters.ballast.stiffness * factor;
  const double damping = parameters.ballast.damping * factor;
  const std::int32_t pad = sleeper.pad_below[side], below = sleeper.ballast[side];
  if (pad >= 0) return between(pad, below, stiffness, damping);
  return under(sleeper, side, between(sleeper.unknown[side], below, stiffness, damping));
}

// Two Kelvin elements in series need an internal variable, which is the height between them: the
// massless unknown of the pad's lower face. Distributed along a sleeper they are in series at each
// point, so that the equivalent springs of the ballast hold for both. The factor `bed` of zones
// applies to the ballast only. Above a gap the pad is attached to the sleeper and unloaded.
void Line::Impl::add_pad_below(std::size_t index, std::size_t side) {
  const Sleeper& sleeper = sleepers[index];
  if (sleeper.pad_below[side] < 0) return;
  const UnderSleeperPadParameters& pad = parameters.under_sleeper;
  const double stiffer =
      run_in(sleeper.x) * zone_factor(&TrackZone::under_sleeper_pad, sleeper.x, side);
  connect(under(sleeper, side,
                between(sleeper.unknown[side], sleeper.pad_below[side], pad.stiffness * stiffer,
                        pad.damping * stiffer)));
}

// A hanging sleeper. Above moved ground the height of the ground is included in the approach.
void Line::Impl::add_gap(std::size_t index, std::size_t side, const Kelvin& bed) {
  stops.push_back(stop_of(bed, parameters.track.gap(sleepers[index].x, side)));
  if (parameters.ballast.mass > 0) return;
  sleepers[index].stop[side] = static_cast<std::int32_t>(stops.size() - 1);
  if (is_of(MovedPart::ground, index))
    stops.back().seat = static_cast<std::int32_t>((index - parameters.first_moved) * sides + side);
}

// Sleeper (- pad) - ballast spring (- ballast mass - spring) - ground.
void Line::Impl::add_ballast(std::size_t index, std::size_t side) {
  Sleeper& sleeper = sleepers[index];
  const BallastParameters& ballast = parameters.ballast;
  add_pad_below(index, side);
  const Kelvin bed = bed_below(sleeper, side);
  Kelvin& lowest = sleeper.lowest[side];
  if (parameters.track.gap(sleeper.x, side) > 0)
    add_gap(index, side, bed);
  else
    connect(lowest = bed);
  if (ballast.mass > 0) {
    const std::int32_t below = sleeper.ballast[side];
    const double factor = bed_factor(sleeper.x, side);
    add(mass, below, below, ballast.mass);
    lowest = between(below, -1, ballast.below_stiffness * factor, ballast.below_damping * factor);
    connect(lowest);
  }
  for (std::size_t k = 0; k < 3; ++k)
    if (lowest.unknown[k] >= 0) sleeper.on[side].emplace_back(lowest.unknown[k], lowest.value[k]);
}

// Sleepers at the ends of the track carry half a spacing but are whole: an error within the run-in.
void Line::Impl::add_sleeper(std::size_t index) {
  for (std::size_t side = 0; parameters.pads && side < sides; ++side) add_pad(index, side);
  if (parameters.pads && sides == 2) join_pads(index);
  if (is_moved(index)) return;
  if (mesh) return add_across(index);
  add_sleeper_mass(sleepers[index]);
  for (std::size_t side = 0; side < sides; ++side) add_ballast(index, side);
}

// Sleepers after elements: the order is irrelevant, since Eigen sums triplets by position.
void Line::Impl::assemble() {
  for (std::size_t e = 0; e < elements; ++e)
    for (std::size_t side = 0; side < sides; ++side) assemble_element(e, side);
  for (std::size_t i = 0; i < sleepers.size(); ++i) add_sleeper(i);
  system = {matrix_of(mass, unknowns), matrix_of(damping, unknowns),
            matrix_of(stiffness, unknowns)};
}

}  // namespace trackbed::track
