// Evaluation of a Line: points of its rails, forces of its pads and stops.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "track/line/line_impl.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

namespace {

constexpr double rounding = 1e-9;      // m, of positions of sleepers, which are sums
constexpr double most_spacings = 1e7;  // of a part; so many elements are refused

}  // namespace

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
  const bool ends = x > length - rounding && to > length - rounding;
  return x > from - rounding && (x < to - rounding || ends) &&
         (side == ZoneSide::both || (side == ZoneSide::left) == (of_side == 0));
}

// The length of a part may differ from whole spacings by rounding of the deck.
std::vector<EvenPart> TrackParameters::even_parts() const {
  std::vector<EvenPart> parts;
  const auto add = [&parts](double from, double to, double apart) {
    parts.push_back({from, to, std::llround(std::clamp((to - from) / apart, 1.0, most_spacings))});
  };
  std::vector<TrackZone> own;
  std::copy_if(zones.begin(), zones.end(), std::back_inserter(own),
               [](const TrackZone& zone) { return zone.spacing > 0; });
  std::sort(own.begin(), own.end(),
            [](const TrackZone& one, const TrackZone& other) { return one.from < other.from; });
  double end = 0;
  for (const TrackZone& zone : own) {
    if (zone.from > end + rounding) add(end, zone.from, spacing);
    add(zone.from, zone.to, zone.spacing);
    end = zone.to;
  }
  if (own.empty() || length > end + rounding) add(end, length, spacing);
  return parts;
}

std::size_t TrackParameters::sleepers() const {
  std::int64_t count = 1;
  for (const EvenPart& part : even_parts()) count += part.count;
  return static_cast<std::size_t>(count);
}

double TrackParameters::sleeper_x(std::size_t n) const {
  auto more = static_cast<std::int64_t>(n);
  for (const EvenPart& part : even_parts()) {
    if (more <= part.count) return part.from + static_cast<double>(more) * part.spacing();
    more -= part.count;
  }
  return length + static_cast<double>(more) * spacing;
}

double TrackParameters::least_spacing() const {
  double least = std::numeric_limits<double>::infinity();
  for (const EvenPart& part : even_parts()) least = std::min(least, part.spacing());
  return least;
}

// Factors of overlapping zones multiply.
double TrackParameters::factor(double TrackZone::*of, double x, std::size_t side) const {
  double factor = 1;
  for (const TrackZone& zone : zones)
    if (zone.covers(x, side, length)) factor *= zone.*of;
  return factor;
}

double TrackParameters::gap(double x, std::size_t side) const {
  double largest = 0;
  for (const TrackZone& zone : zones)
    if (zone.covers(x, side, length)) largest = std::max(largest, zone.gap);
  return largest;
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
std::size_t Line::Impl::element_at(double x) const {
  const auto beyond = std::upper_bound(node_x.begin(), node_x.end(), x) - node_x.begin();
  return static_cast<std::size_t>(
      std::clamp<std::ptrdiff_t>(beyond - 1, 0, static_cast<std::ptrdiff_t>(elements) - 1));
}

RailPoint Line::at(double x, std::size_t side) const {
  RailPoint point;
  if (x < 0 || x > length()) return point;
  const std::size_t e = impl_->element_at(x);
  const double xi = (x - impl_->node_x[e]) / impl_->element_length[e];
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
  // Of two at the same distance the later one, whatever the rounding.
  std::size_t nearest = 0;
  for (std::size_t n = 1; n < sleepers(); ++n)
    if (std::abs(sleeper_x(n) - x) <= std::abs(sleeper_x(nearest) - x) + rounding) nearest = n;
  return nearest;
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
  const std::size_t e = impl.element_at(x);
  const std::size_t node = e + (x - impl.node_x[e] > impl.element_length[e] / 2 ? 1 : 0);
  require(node >= 1 && node <= impl.elements, "bending moments are evaluated left of a node");
  const BeamElement rail = impl.element(node - 1, side);
  Matrix4 k = rail.stiffness();
  if (impl.parameters.track.support == Support::continuous)
    k += impl.parameters.track.bed_stiffness * impl.bed_factor(impl.middle(node - 1), side) *
         rail.bed();
  const auto unknown = impl.unknowns_of(node - 1, side);
  Four ends = Four::Zero();
  for (int i = 0; i < 4; ++i)
    if (unknown[static_cast<std::size_t>(i)] >= 0)
      ends[i] = u[unknown[static_cast<std::size_t>(i)]];
  return (k * ends)[3];
}

}  // namespace trackbed::track
