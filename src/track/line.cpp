// Assembles the track. Unknowns are numbered along x (rail node, then the sleeper and the ballast
// below it), so that the matrices are bands a few numbers wide and every solve is linear in the
// length of the track. A bed under the rail is integrated with the shape functions of w
// (consistent), as the rail's mass is.
// Rejected: sleepers as springs of complex stiffness (frequency domain), which cannot follow a
// wheel that lifts off.
#include "trackbed/track/line.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "beam.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

// A Kelvin element between two unknowns; -1 is the ground.
struct Kelvin {
  std::int32_t upper, lower;
  double stiffness, damping;
};

struct Sleeper {
  double x;
  std::int32_t unknown;
  Kelvin pad;
  double beyond;  // N/m, what the pad adds beyond its knee
};

// Pushes `lower` down and `upper` up when they come together by more than the gap.
Stop stop_between(const Kelvin& element, double gap) {
  RailPoint point;
  point.unknown = {element.upper, element.lower, -1, -1};
  point.value = {-1, 1, 0, 0};
  return {point, gap, element.stiffness, element.damping};
}

// Entries of a matrix in any order; those of one place add up.
using Triplets = std::vector<Eigen::Triplet<double>>;

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

struct Line::Room {
  explicit Room(const LineParameters& given);
  void number();
  void assemble();
  void assemble_element(std::size_t e);
  void connect(const Kelvin& element);
  void add_sleeper(std::size_t node);
  double node_x(std::size_t node) const { return static_cast<double>(node) * element_length; }
  double run_in(double x) const;
  double gap_below(double x) const;
  double bed_factor(double x) const;
  BeamElement element(std::size_t e) const;
  std::array<std::int32_t, 4> unknowns_of(std::size_t e) const;
  bool bears(std::size_t node) const;  // a sleeper
  bool is_moved(std::size_t sleeper) const {
    return sleeper >= parameters.first_moved && sleeper - parameters.first_moved < parameters.moved;
  }

  LineParameters parameters;
  Beam beam;
  std::size_t elements = 0;
  double element_length = 0;                      // m
  std::vector<std::array<std::int32_t, 2>> node;  // unknowns of w and theta
  std::vector<Sleeper> sleepers;
  std::int32_t unknowns = 0;
  Triplets mass, damping, stiffness;
  LinearSystem system;
  std::vector<Stop> stops;
};

// The length was checked to be a whole number of spacings.
Line::Room::Room(const LineParameters& given) : parameters(given), beam(beam_of(given.rail)) {
  const TrackParameters& track = parameters.track;
  const auto bays = std::llround(track.length / track.spacing);
  require(bays >= 1 && track.elements >= 1, "a track has at least one element");
  require(static_cast<std::size_t>(bays) + 1 >= given.first_moved + given.moved,
          "sleepers that are moved are sleepers of the track");
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

// Pinned ends have no unknown for their height; they still turn.
void Line::Room::number() {
  for (std::size_t n = 0; n <= elements; ++n) {
    const bool held = parameters.track.ends == RailEnds::pinned && (n == 0 || n == elements);
    const std::int32_t w = held ? -1 : unknowns++;
    node.push_back({w, unknowns++});
    if (!bears(n)) continue;
    const bool moved = is_moved(sleepers.size());
    sleepers.push_back({node_x(n), moved ? -1 : unknowns++, {}, 0});
    if (!moved && parameters.ballast.mass > 0) ++unknowns;
  }
}

// Over the run-in the rail's stiffness, all springs and dampers grow smoothly, by equal ratios in
// equal parts of half a cosine:
//   factor = F^((1 + cos(pi d/L))/2),   d the distance from the end, L the run-in, m.
// A wheel then comes from a rigid rail onto one that is nearly so, and nothing begins with a jump.
// Without the rail itself in it, wheels would feel the sleepers of the run-in ten times as much.
double Line::Room::run_in(double x) const {
  const TrackParameters& track = parameters.track;
  const double distance = std::min(x, track.length - x);
  if (distance >= track.run_in) return 1;
  const double share = (1 + std::cos(std::numbers::pi * distance / track.run_in)) / 2;
  return std::pow(track.run_in_factor, share);
}

// Of bed or ballast at x: zones that overlap multiply.
double Line::Room::bed_factor(double x) const {
  double factor = run_in(x);
  for (const TrackZone& zone : parameters.track.zones)
    if (x >= zone.from && x <= zone.to) factor *= zone.bed;
  return factor;
}

// Of zones that overlap the widest.
double Line::Room::gap_below(double x) const {
  double gap = 0;
  for (const TrackZone& zone : parameters.track.zones)
    if (x >= zone.from && x <= zone.to) gap = std::max(gap, zone.gap);
  return gap;
}

// An element belongs to the zone its middle lies in: a border between nodes moves to the next one.
// Made anew at each call, which costs less than keeping one per element in step with its zone.
BeamElement Line::Room::element(std::size_t e) const {
  const double middle = (static_cast<double>(e) + 0.5) * element_length;
  double factor = 1;
  for (const TrackZone& zone : parameters.track.zones)
    if (middle >= zone.from && middle <= zone.to) factor *= zone.rail;
  Beam here = beam.times(factor);
  here.bending_stiffness *= run_in(middle);
  here.shear_stiffness *= run_in(middle);
  return {here, element_length};
}

std::array<std::int32_t, 4> Line::Room::unknowns_of(std::size_t e) const {
  return {node[e][0], node[e][1], node[e + 1][0], node[e + 1][1]};
}

// Rail and, if it is continuous, the bed below it. The bed's damping is that of dampers side by
// side, so it has the same shape functions.
void Line::Room::assemble_element(std::size_t e) {
  const BeamElement rail = element(e);
  Matrix4 k = rail.stiffness(), c = Matrix4::Zero();
  const Matrix4 m = rail.mass();
  if (parameters.track.support == Support::continuous) {
    const double factor = bed_factor((static_cast<double>(e) + 0.5) * element_length);
    k += parameters.track.bed_stiffness * factor * rail.bed();
    c += parameters.track.bed_damping * factor * rail.bed();
  }
  const auto unknown = unknowns_of(e);
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
  const auto into = [&](Triplets& to, double value) {
    add(to, element.upper, element.upper, value);
    add(to, element.lower, element.lower, value);
    add(to, element.upper, element.lower, -value);
    add(to, element.lower, element.upper, -value);
  };
  into(stiffness, element.stiffness);
  into(damping, element.damping);
}

// Rail node - pad - half sleeper - ballast spring (- ballast mass - spring) - ground.
// A ballast mass has the number after its sleeper. Sleepers at the very ends carry half a spacing,
// but are whole: the run-in hides it.
void Line::Room::add_sleeper(std::size_t index) {
  Sleeper& sleeper = sleepers[index];
  const BallastParameters& ballast = parameters.ballast;
  const double factor = bed_factor(sleeper.x);
  const std::size_t at = index * static_cast<std::size_t>(parameters.track.elements);
  const PadParameters& pad = parameters.pad;
  const double stiffer = run_in(sleeper.x);
  sleeper.pad = {node[at][0], sleeper.unknown, pad.stiffness * stiffer, pad.damping * stiffer};
  connect(sleeper.pad);
  if (pad.knee > 0) {
    sleeper.beyond = (pad.beyond - pad.stiffness) * stiffer;
    stops.push_back(
        stop_between({node[at][0], sleeper.unknown, sleeper.beyond, 0}, pad.knee / stiffer));
    if (is_moved(index))
      stops.back().seat = static_cast<std::int32_t>(index - parameters.first_moved);
  }
  if (is_moved(index)) return;
  add(mass, sleeper.unknown, sleeper.unknown,
      parameters.track.sleeper_mass / static_cast<double>(parameters.track.rails));
  const std::int32_t below = ballast.mass > 0 ? sleeper.unknown + 1 : -1;
  const Kelvin bed = {sleeper.unknown, below, ballast.stiffness * factor, ballast.damping * factor};
  if (const double gap = gap_below(sleeper.x); gap > 0)
    stops.push_back(stop_between(bed, gap));
  else
    connect(bed);
  if (below < 0) return;
  add(mass, below, below, ballast.mass);
  connect({below, -1, ballast.below_stiffness * factor, ballast.below_damping * factor});
}

// Sleepers after elements: the order does not matter to sums of triplets, which Eigen adds in the
// order of their places.
void Line::Room::assemble() {
  for (std::size_t e = 0; e < elements; ++e) assemble_element(e);
  for (std::size_t i = 0; i < sleepers.size(); ++i) add_sleeper(i);
  system = {matrix_of(mass, unknowns), matrix_of(damping, unknowns),
            matrix_of(stiffness, unknowns)};
}

// A damper that began with its full force would make a jump at touching, which Newton's method of
// the contacts cannot find its way around.
double Stop::force(double approach, double rate) const {
  if (approach <= 0) return 0;
  const double spring = stiffness * approach;
  return spring + std::clamp(damping * rate, -spring, spring);
}

// The derivative of the force above, piece by piece.
double Stop::slope(double approach, double rate, double rate_slope) const {
  if (approach <= 0) return 0;
  const double spring = stiffness * approach, damper = damping * rate;
  if (std::abs(damper) < spring) return stiffness + damping * rate_slope;
  return damper > 0 ? 2 * stiffness : 0;
}

double RailPoint::deflection(const Vector& u) const {
  double sum = 0;
  for (std::size_t k = 0; k < 4; ++k)
    if (unknown[k] >= 0) sum += value[k] * u[unknown[k]];
  return sum;
}

void RailPoint::add(double force, Vector& to) const {
  for (std::size_t k = 0; k < 4; ++k)
    if (unknown[k] >= 0) to[unknown[k]] += value[k] * force;
}

Line::Line(const LineParameters& parameters) : room_(std::make_unique<Room>(parameters)) {}
Line::~Line() = default;
Line::Line(Line&&) noexcept = default;

const LinearSystem& Line::system() const { return room_->system; }
const std::vector<Stop>& Line::stops() const { return room_->stops; }
double Line::length() const { return room_->parameters.track.length; }
std::size_t Line::sleepers() const { return room_->sleepers.size(); }
double Line::sleeper_x(std::size_t i) const { return room_->sleepers.at(i).x; }
std::int32_t Line::sleeper_unknown(std::size_t i) const { return room_->sleepers.at(i).unknown; }
std::size_t Line::first_moved() const { return room_->parameters.first_moved; }
std::size_t Line::moved() const { return room_->parameters.moved; }

// The last element also holds the end itself.
RailPoint Line::at(double x) const {
  RailPoint point;
  if (x < 0 || x > length()) return point;
  const double along = x / room_->element_length;
  const std::size_t e = std::min(static_cast<std::size_t>(along), room_->elements - 1);
  const double xi = along - static_cast<double>(e);
  const BeamElement rail = room_->element(e);
  const Four shape = rail.deflection(xi);
  point.unknown = room_->unknowns_of(e);
  for (std::size_t k = 0; k < 4; ++k) point.value[k] = shape[static_cast<Eigen::Index>(k)];
  point.local = rail.local_flexibility(xi);
  return point;
}

std::size_t Line::nearest_sleeper(double x) const {
  const auto last = static_cast<double>(sleepers() - 1);
  const double number = std::round(x / room_->parameters.track.spacing);
  return static_cast<std::size_t>(std::clamp(number, 0.0, last));
}

// What the pad gives to the sleeper; its inertia is none, so the rail gets the same.
double Line::seat_force(std::size_t i, const Vector& u, const Vector& v, const Seat& seat) const {
  const Sleeper& sleeper = room_->sleepers.at(i);
  const Kelvin& pad = sleeper.pad;
  const auto of = [&](const Vector& y, double given) {
    return (pad.lower >= 0 ? y[pad.lower] : given) - (pad.upper >= 0 ? y[pad.upper] : 0.0);
  };
  // Over a run-in all is as much stiffer as the knee comes earlier.
  const double knee = room_->parameters.pad.knee / room_->run_in(sleeper.x);
  const double pressed = of(u, seat.height);
  return pad.stiffness * pressed + pad.damping * of(v, seat.rate) +
         sleeper.beyond * std::max(0.0, pressed - knee);
}

// The linear part: that beyond a knee is a stop.
void Line::add_seats(const std::vector<Seat>& seats, Vector& to) const {
  require(seats.size() == moved(), "one seat for each sleeper that is moved");
  for (std::size_t k = 0; k < seats.size(); ++k) {
    const Kelvin& pad = room_->sleepers[first_moved() + k].pad;
    if (pad.upper >= 0)
      to[pad.upper] += pad.stiffness * seats[k].height + pad.damping * seats[k].rate;
  }
}

// The element's own end moment is exact for its loads at nodes; of a bed's force between nodes it
// has the consistent share.
double Line::bending_moment(double x, const Vector& u) const {
  const Room& room = *room_;
  const auto node = static_cast<std::size_t>(std::llround(x / room.element_length));
  require(node >= 1 && node <= room.elements, "a bending moment is asked for left of a node");
  const BeamElement rail = room.element(node - 1);
  Matrix4 k = rail.stiffness();
  if (room.parameters.track.support == Support::continuous)
    k += room.parameters.track.bed_stiffness *
         room.bed_factor((static_cast<double>(node) - 0.5) * room.element_length) * rail.bed();
  const auto unknown = room.unknowns_of(node - 1);
  Four ends = Four::Zero();
  for (int i = 0; i < 4; ++i)
    if (unknown[static_cast<std::size_t>(i)] >= 0)
      ends[i] = u[unknown[static_cast<std::size_t>(i)]];
  return (k * ends)[3];
}

}  // namespace trackbed::track
