// Evaluation of a Line: points of its rails, forces of its pads and stops.
#include <algorithm>
#include <cmath>

#include "track/line/line_impl.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

// An unlimited damper force would jump when the gap closes, and Newton's method of the contacts
// would not converge.
double Stop::force(double approach, double rate) const {
  const double spring = stiffness * approach, damper = damping * rate;
  const double linear = in_matrix ? spring + damper : 0;
  if (approach <= 0) return 0 - linear;
  return spring + std::clamp(damper, -spring, spring) - linear;
}

// The derivative of the force above, piece by piece.
double Stop::slope(double approach, double rate, double rate_slope) const {
  const double linear = in_matrix ? stiffness + damping * rate_slope : 0;
  if (approach <= 0) return 0 - linear;
  const double spring = stiffness * approach, damper = damping * rate;
  if (std::abs(damper) < spring) return stiffness + damping * rate_slope - linear;
  return (damper > 0 ? 2 * stiffness : 0) - linear;
}

// The integral of the spring's force above over the approach.
double Stop::energy(double approach) const {
  const double spring = stiffness * approach * approach / 2;
  if (approach <= 0) return in_matrix ? -spring : 0;
  return in_matrix ? 0 : spring;
}

// A position on the common border of two zones belongs to the second zone only. At the end of the
// track there is no second zone.
bool TrackZone::covers(double x, std::size_t of_side, double length) const {
  constexpr double rounding = 1e-9;  // m, of positions of sleepers, which are sums
  const bool ends = x > length - rounding && to > length - rounding;
  return x > from - rounding && (x < to - rounding || ends) &&
         (side == ZoneSide::both || (side == ZoneSide::left) == (of_side == 0));
}

// As the rail's nodes: the length may differ from whole spacings by rounding of the deck.
double TrackParameters::sleeper_x(std::size_t n) const {
  return static_cast<double>(n) * (length / std::round(length / spacing));
}

// Factors of overlapping zones multiply.
double TrackParameters::factor(double TrackZone::*of, double x, std::size_t side) const {
  double factor = 1;
  for (const TrackZone& zone : zones)
    if (zone.covers(x, side, length)) factor *= zone.*of;
  return factor;
}

// Limits as for zones.
bool UnderSleeperPadParameters::lie_at(double x, double length) const {
  return stiffness > 0 && TrackZone{.from = from, .to = to > 0 ? to : length}.covers(x, 0, length);
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

Line::Line(const LineParameters& parameters) : impl_(std::make_unique<Impl>(parameters)) {}
Line::~Line() = default;
Line::Line(Line&&) noexcept = default;

const LinearSystem& Line::system() const { return impl_->system; }
const std::vector<Stop>& Line::stops() const { return impl_->stops; }
double Line::gauge() const { return impl_->parameters.track.gauge; }
double Line::length() const { return impl_->parameters.track.length; }
std::size_t Line::sleepers() const { return impl_->sleepers.size(); }
double Line::sleeper_x(std::size_t i) const { return impl_->sleepers.at(i).x; }
std::int32_t Line::sleeper_unknown(std::size_t i, std::size_t side) const {
  return impl_->sleepers.at(i).unknown.at(side);
}
std::size_t Line::sides() const { return impl_->sides; }
std::size_t Line::first_moved() const { return impl_->parameters.first_moved; }
std::size_t Line::moved() const { return impl_->parameters.moved; }
MovedPart Line::moves() const { return impl_->parameters.moves; }
std::size_t Line::seats() const { return moved() * sides(); }

// The last element includes the end of the track.
RailPoint Line::at(double x, std::size_t side) const {
  RailPoint point;
  if (x < 0 || x > length()) return point;
  const double along = x / impl_->element_length;
  const std::size_t e = std::min(static_cast<std::size_t>(along), impl_->elements - 1);
  const double xi = along - static_cast<double>(e);
  const BeamElement rail = impl_->element(e, side);
  const Four shape = rail.deflection(xi);
  point.unknown = impl_->unknowns_of(e, side);
  for (std::size_t k = 0; k < 4; ++k) point.value[k] = shape[static_cast<Eigen::Index>(k)];
  point.local = rail.local_flexibility(xi);
  return point;
}

std::vector<RailNodes> Line::rail_nodes() const {
  std::vector<RailNodes> nodes(impl_->elements + 1, RailNodes{-1, -1, -1, -1});
  for (std::size_t side = 0; side < sides(); ++side)
    for (std::size_t n = 0; n < nodes.size(); ++n)
      std::copy_n(impl_->nodes[side][n].begin(), 2, nodes[n].begin() + 2 * side);
  return nodes;
}

std::size_t Line::nearest_sleeper(double x) const {
  const auto last = static_cast<double>(sleepers() - 1);
  const double number = std::round(x / impl_->parameters.track.spacing);
  return static_cast<std::size_t>(std::clamp(number, 0.0, last));
}

// The pad has no mass, so that its force on sleeper and rail is the same.
double Line::seat_force(std::size_t i, const Vector& u, const Vector& v,
                        const std::array<Seat, 2>& seats, std::size_t side) const {
  const Sleeper& sleeper = impl_->sleepers.at(i);
  const Kelvin& pad = sleeper.pad.at(side);
  const auto of = [](const Kelvin& one, const Vector& y, double given) {
    const auto [rail, below, none] = one.unknown;
    return (below >= 0 ? y[below] : given) - (rail >= 0 ? y[rail] : 0.0);
  };
  const Seat& seat = seats.at(side);
  // In the run-in bilinear_at is divided by the factor of the stiffness.
  const double bilinear_at = impl_->parameters.pad.bilinear_at / impl_->run_in(sleeper.x);
  const double compression = of(pad, u, seat.height), rate = of(pad, v, seat.rate);
  const double stiffer = sleeper.additional.at(side) * std::max(0.0, compression - bilinear_at);
  if (impl_->parameters.pad.uplift) {
    const double preload = impl_->preload(i, side);
    const double whole = compression + preload / pad.stiffness;  // m, from the unloaded pad
    return Stop{{}, 0, pad.stiffness, pad.damping}.force(whole, rate) - preload + stiffer;
  }
  double across = 0;
  if (sleeper.across_stiffness != 0) {
    const Kelvin& pad_across = sleeper.pad.at(1 - side);
    const Seat& other = seats.at(1 - side);
    across = sleeper.across_stiffness * of(pad_across, u, other.height) +
             sleeper.across_damping * of(pad_across, v, other.rate);
  }
  return pad.stiffness * compression + pad.damping * rate + stiffer + across;
}

double Line::ground_force(std::size_t i, const Vector& u, const Vector& v, const Seat& seat,
                          std::size_t side) const {
  const Sleeper& sleeper = impl_->sleepers.at(i);
  const Kelvin& lowest = sleeper.lowest.at(side);
  if (sleeper.on[side].empty()) return 0;  // it has a gap
  double height = 0, rate = 0;
  for (const auto& [unknown, factor] : sleeper.on[side])
    height += factor * u[unknown], rate += factor * v[unknown];
  return lowest.stiffness * (seat.height - height) + lowest.damping * (seat.rate - rate);
}

std::int32_t Line::ground_stop(std::size_t i, std::size_t side) const {
  return impl_->sleepers.at(i).stop.at(side);
}

std::array<double, 2> Line::ground_spring(std::size_t i, std::size_t side) const {
  const Kelvin& lowest = impl_->sleepers.at(i).lowest.at(side);
  const std::int32_t number = ground_stop(i, side);
  if (number < 0) return {lowest.stiffness, lowest.damping};
  const Stop& stop = stops()[static_cast<std::size_t>(number)];
  return {stop.stiffness, stop.damping};
}

// The linear part: additional stiffness of bilinear pads and gaps are stops.
void Line::add_seats(const std::vector<Seat>& seats, Vector& to) const {
  require(seats.size() == this->seats(), "one seat for each rail on a moved sleeper");
  const bool ground = impl_->parameters.moves == MovedPart::ground;
  for (std::size_t k = 0; k < seats.size(); ++k) {
    const Sleeper& sleeper = impl_->sleepers[first_moved() + k / sides()];
    const Kelvin& held = (ground ? sleeper.lowest : sleeper.pad)[k % sides()];
    const double force = held.stiffness * seats[k].height + held.damping * seats[k].rate;
    if (!ground && held.unknown[0] >= 0) to[held.unknown[0]] += force;
    if (!ground && sides() == 2) {
      const std::int32_t rail = sleeper.pad[1 - k % 2].unknown[0];
      if (rail >= 0)
        to[rail] +=
            sleeper.across_stiffness * seats[k].height + sleeper.across_damping * seats[k].rate;
    }
    if (!ground) continue;
    for (const auto& [unknown, factor] : sleeper.on[k % sides()]) to[unknown] += factor * force;
  }
}

// The end moment of the element is exact for loads at nodes; forces of a bed between nodes are
// included as consistent forces.
double Line::bending_moment(double x, const Vector& u, std::size_t side) const {
  const Impl& impl = *impl_;
  const auto node = static_cast<std::size_t>(std::llround(x / impl.element_length));
  require(node >= 1 && node <= impl.elements, "bending moments are evaluated left of a node");
  const BeamElement rail = impl.element(node - 1, side);
  Matrix4 k = rail.stiffness();
  if (impl.parameters.track.support == Support::continuous)
    k += impl.parameters.track.bed_stiffness *
         impl.bed_factor((static_cast<double>(node) - 0.5) * impl.element_length, side) *
         rail.bed();
  const auto unknown = impl.unknowns_of(node - 1, side);
  Four ends = Four::Zero();
  for (int i = 0; i < 4; ++i)
    if (unknown[static_cast<std::size_t>(i)] >= 0)
      ends[i] = u[unknown[static_cast<std::size_t>(i)]];
  return (k * ends)[3];
}

}  // namespace trackbed::track
