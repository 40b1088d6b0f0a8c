// Assembles the track. Unknowns are numbered along x (rail node, then the sleeper and the ballast
// below it), so that the matrices are bands a few numbers wide and every solve is linear in the
// length of the track. A bed under the rail is integrated with the shape functions of w
// (consistent), as the rail's mass is.
// Rejected: sleepers as springs of complex stiffness (frequency domain), which cannot follow a
// wheel that lifts off.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "line_room.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

// Between two unknowns; -1 is the ground.
Kelvin between(std::int32_t upper, std::int32_t lower, double stiffness, double damping) {
  return {{upper, lower, -1}, {1, -1, 0}, stiffness, damping};
}

// Pushes as the element would that has been pressed by the gap.
Stop stop_of(const Kelvin& element, double gap) {
  RailPoint point;
  for (std::size_t k = 0; k < 3; ++k) {
    point.unknown[k] = element.unknown[k];
    point.value[k] = -element.value[k];
  }
  return {point, gap, element.stiffness, element.damping};
}

// Rows and columns of -1 are held or are the ground: nothing is kept of them.
void add(Triplets& to, std::int32_t row, std::int32_t column, double value) {
  if (row >= 0 && column >= 0 && value != 0) to.emplace_back(row, column, value);
}

Sparse matrix_of(const Triplets& entries, std::int32_t unknowns) {
  Sparse matrix(unknowns, unknowns);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

// The length was checked to be a whole number of spacings.
Line::Room::Room(const LineParameters& given)
    : parameters(given),
      beam(beam_of(given.rail)),
      sides(given.track.dimension == Dimension::space ? 2 : 1) {
  const TrackParameters& track = parameters.track;
  const auto bays = std::llround(track.length / track.spacing);
  require(bays >= 1 && track.elements >= 1, "a track has at least one element");
  require(static_cast<std::size_t>(bays) + 1 >= given.first_moved + given.moved,
          "sleepers that are moved are sleepers of the track");
  if (track.sleeper.model == SleeperModel::beam) mesh.emplace(track);
  require(!mesh || (given.ballast.mass == 0 && (sides == 2 || track.rails == 2)),
          "sleepers that bend are whole ones, or halves of them, right on ballast springs");
  require(!mesh || given.under_sleeper.stiffness == 0, "pads lie below rigid sleepers");
  require(given.pads || given.moved == 0 || given.moves == MovedPart::ground,
          "seat loads are those of sleepers on springs");
  require(given.moved_pads.empty() || given.pad.knee == 0,
          "pads with a knee stand on sleepers that do not give way within a step");
  require(!given.pad.uplift || given.moved == 0, "pads lift off on a track alone");
  require(!mesh || given.moved == 0 || given.moves == MovedPart::ground,
          "sleepers that somebody else moves do not bend");
  elements = static_cast<std::size_t>(bays * track.elements);
  element_length = track.length / static_cast<double>(elements);
  number();
  assemble();
}

// Sleepers stand at the first node of each spacing and at the very end.
bool Line::Room::bears(std::size_t node) const {
  return parameters.track.support == Support::sleepers &&
         node % static_cast<std::size_t>(parameters.track.elements) == 0;
}

// Pinned ends have no unknown for their height; they still turn. Left before right, from above to
// below.
void Line::Room::number() {
  for (std::size_t n = 0; n <= elements; ++n) {
    const bool held = parameters.track.ends == RailEnds::pinned && (n == 0 || n == elements);
    for (std::size_t side = 0; side < sides; ++side) {
      const std::int32_t w = held ? -1 : unknowns++;
      nodes[side].push_back({w, unknowns++});
    }
    if (!bears(n)) continue;
    Sleeper sleeper{.x = node_x(n), .unknown = {-1, -1}, .pad = {}};
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

// Over the run-in the rail's stiffness, all springs and dampers grow smoothly, by equal ratios in
// equal parts of half a cosine:
//   factor = F^((1 + cos(pi d/L))/2),   d the distance from the end, L the run-in, m.
// A wheel then comes from a rigid rail onto one that is nearly so, and nothing begins with a jump.
// Without the rail itself in it, wheels would feel the sleepers of the run-in ten times as much.
// A rail without support is a bridge: where its ends are is given, and all of it bends.
double Line::Room::run_in(double x) const {
  const TrackParameters& track = parameters.track;
  if (track.support == Support::none) return 1;
  const double distance = std::min(x, track.length - x);
  if (distance >= track.run_in) return 1;
  const double share = (1 + std::cos(std::numbers::pi * distance / track.run_in)) / 2;
  return std::pow(track.run_in_factor, share);
}

// Of bed or ballast at x: zones that overlap multiply.
double Line::Room::bed_factor(double x, std::size_t side) const {
  double factor = run_in(x);
  for (const TrackZone& zone : parameters.track.zones)
    if (zone.covers(x, side, parameters.track.length)) factor *= zone.bed;
  return factor;
}

// Of zones that overlap the widest.
double Line::Room::gap_below(double x, std::size_t side) const {
  double gap = 0;
  for (const TrackZone& zone : parameters.track.zones)
    if (zone.covers(x, side, parameters.track.length)) gap = std::max(gap, zone.gap);
  return gap;
}

double Line::Room::rail_factor(std::size_t e, std::size_t side) const {
  const double middle = (static_cast<double>(e) + 0.5) * element_length;
  double factor = 1;
  for (const TrackZone& zone : parameters.track.zones)
    if (zone.covers(middle, side, parameters.track.length)) factor *= zone.rail;
  return factor;
}

// An element belongs to the zone its middle lies in: a border between nodes moves to the next one.
// Made anew at each call, which costs less than keeping one per element in step with its zone.
BeamElement Line::Room::element(std::size_t e, std::size_t side) const {
  const double middle = (static_cast<double>(e) + 0.5) * element_length;
  Beam here = beam.times(rail_factor(e, side));
  here.bending_stiffness *= run_in(middle);
  here.shear_stiffness *= run_in(middle);
  return {here, element_length};
}

std::array<std::int32_t, 4> Line::Room::unknowns_of(std::size_t e, std::size_t side) const {
  const std::vector<RailNode>& node = nodes[side];
  return {node[e][0], node[e][1], node[e + 1][0], node[e + 1][1]};
}

// Rail and, if it is continuous, the bed below it. The bed's damping is that of dampers side by
// side, so it has the same shape functions.
void Line::Room::assemble_element(std::size_t e, std::size_t side) {
  const BeamElement rail = element(e, side);
  Matrix4 k = rail.stiffness(), c = Matrix4::Zero();
  const Matrix4 m = rail.mass();
  if (parameters.track.support == Support::continuous) {
    const double factor = bed_factor((static_cast<double>(e) + 0.5) * element_length, side);
    k += parameters.track.bed_stiffness * factor * rail.bed();
    c += parameters.track.bed_damping * factor * rail.bed();
  }
  add_element(unknowns_of(e, side), m, c, k);
}

void Line::Room::add_element(const std::array<std::int32_t, 4>& unknown, const Matrix4& m,
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

// Of a spring and a damper side by side: pulls as well as it pushes, since what it pulls is the
// weight of the track, which is not in the model.
void Line::Room::connect(const Kelvin& element) {
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t b = 0; b < 3; ++b) {
      const double both = element.value[a] * element.value[b];
      add(stiffness, element.unknown[a], element.unknown[b], both * element.stiffness);
      add(damping, element.unknown[a], element.unknown[b], both * element.damping);
    }
}

// Of sleepers that give way under the force of their pads within a step (on_bed.cpp).
Matrix2 Line::Room::moved_pads(std::size_t index) const {
  if (!is_moved(index) || parameters.moved_pads.empty()) return Matrix2::Identity();
  return parameters.moved_pads.at(index - parameters.first_moved);
}

// N, at rest on a pad, from which all forces of the line count; the rail's weight of half the bays
// beside it, unless a number is given.
double Line::Room::preload(std::size_t index, std::size_t side) const {
  if (parameters.pad.preload >= 0) return parameters.pad.preload;
  const auto bay = static_cast<std::size_t>(parameters.track.elements);
  const std::size_t at = index * bay, elements = nodes[side].size() - 1;
  double mass = 0;
  for (std::size_t e = at - std::min(at, bay); e < std::min(at + bay, elements); ++e)
    mass += beam.times(rail_factor(e, side)).mass * element_length / 2;
  return mass * gravity;
}

// Rail node - pad - sleeper. Over the run-in all is as much stiffer as the knee comes earlier.
void Line::Room::add_pad(std::size_t index, std::size_t side) {
  Sleeper& sleeper = sleepers[index];
  const PadParameters& pad = parameters.pad;
  const std::size_t at = index * static_cast<std::size_t>(parameters.track.elements);
  const std::int32_t rail = nodes[side][at][0], below = sleeper.unknown[side];
  const auto own = static_cast<Eigen::Index>(side);
  const double stiffer = run_in(sleeper.x) * moved_pads(index)(own, own);
  sleeper.pad[side] = between(rail, below, pad.stiffness * stiffer, pad.damping * stiffer);
  connect(sleeper.pad[side]);
  if (pad.uplift) {
    stops.push_back(
        stop_of(sleeper.pad[side], -preload(index, side) / sleeper.pad[side].stiffness));
    stops.back().in_matrix = true;
  }
  if (pad.knee == 0) return;
  sleeper.beyond[side] = (pad.beyond - pad.stiffness) * stiffer;
  stops.push_back(stop_of(between(rail, below, sleeper.beyond[side], 0), pad.knee / stiffer));
  if (is_moved(index))
    stops.back().seat = static_cast<std::int32_t>((index - parameters.first_moved) * sides + side);
}

// The force of one pad moves the seat of the other.
void Line::Room::join_pads(std::size_t index) {
  Sleeper& sleeper = sleepers[index];
  const double across = run_in(sleeper.x) * moved_pads(index)(0, 1);
  sleeper.across_stiffness = parameters.pad.stiffness * across;
  sleeper.across_damping = parameters.pad.damping * across;
  for (std::size_t side = 0; side < 2; ++side) {
    const std::int32_t one = sleeper.pad[side].unknown[0], other = sleeper.pad[1 - side].unknown[0];
    add(stiffness, one, other, sleeper.across_stiffness);
    add(damping, one, other, sleeper.across_damping);
  }
}

// Half a sleeper for one rail. Of a whole one, with heights z_l, z_r below its rails,
//   z = (z_l + z_r)/2,   phi = (z_l - z_r)/g:   m z'^2/2 + I phi'^2/2,
// g the gauge, m; I that of a uniform bar as long as the sleeper unless given, kg m^2.
void Line::Room::add_sleeper_mass(const Sleeper& sleeper) {
  const TrackParameters& track = parameters.track;
  const auto [left, right] = sleeper.unknown;
  if (sides == 1)
    return add(mass, left, left, track.sleeper_mass / static_cast<double>(track.rails));
  const double roll = track.sleeper_inertia > 0
                          ? track.sleeper_inertia
                          : track.sleeper_mass * track.sleeper_length * track.sleeper_length / 12;
  const double bounce = track.sleeper_mass / 4, turn = roll / (track.gauge * track.gauge);
  for (const std::int32_t one : {left, right})
    for (const std::int32_t other : {left, right})
      add(mass, one, other, one == other ? bounce + turn : bounce - turn);
}

// Ballast spread evenly from a to b on both sides of a rigid sleeper's middle is the same as two
// springs at y = sqrt((a^2 + a b + b^2)/3) from it: both resist bounce and roll alike, k and k y^2;
// y = L/sqrt(12) all along a sleeper of length L. With gaps they are what its two ends strike.
double TrackParameters::bearing_arm() const {
  if (dimension == Dimension::plane) return 0;
  const double half = sleeper_length / 2, none = sleeper.unsupported / 2;
  return std::sqrt((half * half + half * none + none * none) / 3);
}

// A point at y has the height z_l (1/2 + y/g) + z_r (1/2 - y/g). `one` stands below the left side's
// unknown alone.
Kelvin Line::Room::under(const Sleeper& sleeper, std::size_t side, const Kelvin& one) const {
  if (sides == 1) return one;
  const double aside = parameters.track.bearing_arm() / parameters.track.gauge;
  return {{one.unknown[0], sleeper.unknown[1 - side], one.unknown[1]},
          {0.5 + aside, 0.5 - aside, -1},
          one.stiffness,
          one.damping};
}

// Below a pad, if there is one, whose lower face has no other place than that of its end.
Kelvin Line::Room::bed_below(const Sleeper& sleeper, std::size_t side) const {
  const double factor = bed_factor(sleeper.x, side);
  const double stiffness = parameters.ballast.stiffness * factor;
  const double damping = parameters.ballast.damping * factor;
  const std::int32_t pad = sleeper.pad_below[side], below = sleeper.ballast[side];
  if (pad >= 0) return between(pad, below, stiffness, damping);
  return under(sleeper, side, between(sleeper.unknown[side], below, stiffness, damping));
}

// Two Kelvin springs in series answer with three derivatives, which the height between them, an
// unknown without mass, carries exactly: of the pad's lower face. Spread along a sleeper they are
// in series at each place, so ends that stand for ballast stand for both. Factors of zones are the
// ballast's alone. Where the sleeper hangs the pad hangs below it, at its own length.
void Line::Room::add_pad_below(std::size_t index, std::size_t side) {
  const Sleeper& sleeper = sleepers[index];
  if (sleeper.pad_below[side] < 0) return;
  const UnderSleeperPadParameters& pad = parameters.under_sleeper;
  const double stiffer = run_in(sleeper.x);
  connect(under(sleeper, side,
                between(sleeper.unknown[side], sleeper.pad_below[side], pad.stiffness * stiffer,
                        pad.damping * stiffer)));
}

// A sleeper that hangs over ground that moves meets it where it is.
void Line::Room::hang(std::size_t index, std::size_t side, const Kelvin& bed) {
  stops.push_back(stop_of(bed, gap_below(sleepers[index].x, side)));
  if (parameters.ballast.mass > 0) return;
  sleepers[index].stop[side] = static_cast<std::int32_t>(stops.size() - 1);
  if (is_of(MovedPart::ground, index))
    stops.back().seat = static_cast<std::int32_t>((index - parameters.first_moved) * sides + side);
}

// Sleeper (- pad) - ballast spring (- ballast mass - spring) - ground.
void Line::Room::add_ballast(std::size_t index, std::size_t side) {
  Sleeper& sleeper = sleepers[index];
  const BallastParameters& ballast = parameters.ballast;
  add_pad_below(index, side);
  const Kelvin bed = bed_below(sleeper, side);
  Kelvin& lowest = sleeper.lowest[side];
  if (gap_below(sleeper.x, side) > 0)
    hang(index, side, bed);
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

// Sleepers at the very ends carry half a spacing, but are whole: the run-in hides it.
void Line::Room::add_sleeper(std::size_t index) {
  for (std::size_t side = 0; parameters.pads && side < sides; ++side) add_pad(index, side);
  if (parameters.pads && sides == 2) join_pads(index);
  if (is_moved(index)) return;
  if (mesh) return add_across(index);
  add_sleeper_mass(sleepers[index]);
  for (std::size_t side = 0; side < sides; ++side) add_ballast(index, side);
}

// Sleepers after elements: the order does not matter to sums of triplets, which Eigen adds in the
// order of their places.
void Line::Room::assemble() {
  for (std::size_t e = 0; e < elements; ++e)
    for (std::size_t side = 0; side < sides; ++side) assemble_element(e, side);
  for (std::size_t i = 0; i < sleepers.size(); ++i) add_sleeper(i);
  system = {matrix_of(mass, unknowns), matrix_of(damping, unknowns),
            matrix_of(stiffness, unknowns)};
}

}  // namespace trackbed::track
