// What a Line tells: points of its rails, forces of its pads and stops.
#include <algorithm>
#include <cmath>

#include "line_room.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::track {

// A damper that began with its full force would make a jump at touching, which Newton's method of
// the contacts cannot find its way around.
double Stop::force(double approach, double rate) const {
  const double spring = stiffness * approach, damper = damping * rate;
  const double there = in_matrix ? spring + damper : 0;
  if (approach <= 0) return 0 - there;
  return spring + std::clamp(damper, -spring, spring) - there;
}

// The derivative of the force above, piece by piece.
double Stop::slope(double approach, double rate, double rate_slope) const {
  const double there = in_matrix ? stiffness + damping * rate_slope : 0;
  if (approach <= 0) return 0 - there;
  const double spring = stiffness * approach, damper = damping * rate;
  if (std::abs(damper) < spring) return stiffness + damping * rate_slope - there;
  return (damper > 0 ? 2 * stiffness : 0) - there;
}

// The integral of the spring's force above over the approach.
double Stop::energy(double approach) const {
  const double spring = stiffness * approach * approach / 2;
  if (approach <= 0) return in_matrix ? -spring : 0;
  return in_matrix ? 0 : spring;
}

// A place on the border of two zones that touch belongs to the second one, and to it alone. The end
// of the track has no second one.
bool TrackZone::covers(double x, std::size_t of_side, double length) const {
  constexpr double rounding = 1e-9;  // m, of places of sleepers, which are sums
  const bool ends = x > length - rounding && to > length - rounding;
  return x > from - rounding && (x < to - rounding || ends) &&
         (side == ZoneSide::both || (side == ZoneSide::left) == (of_side == 0));
}

// Borders as those of zones.
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

Line::Line(const LineParameters& parameters) : room_(std::make_unique<Room>(parameters)) {}
Line::~Line() = default;
Line::Line(Line&&) noexcept = default;

const LinearSystem& Line::system() const { return room_->system; }
const std::vector<Stop>& Line::stops() const { return room_->stops; }
double Line::gauge() const { return room_->parameters.track.gauge; }
double Line::length() const { return room_->parameters.track.length; }
std::size_t Line::sleepers() const { return room_->sleepers.size(); }
double Line::sleeper_x(std::size_t i) const { return room_->sleepers.at(i).x; }
std::int32_t Line::sleeper_unknown(std::size_t i, std::size_t side) const {
  return room_->sleepers.at(i).unknown.at(side);
}
std::size_t Line::sides() const { return room_->sides; }
std::size_t Line::first_moved() const { return room_->parameters.first_moved; }
std::size_t Line::moved() const { return room_->parameters.moved; }
MovedPart Line::moves() const { return room_->parameters.moves; }
std::size_t Line::seats() const { return moved() * sides(); }

// The last element also holds the end itself.
RailPoint Line::at(double x, std::size_t side) const {
  RailPoint point;
  if (x < 0 || x > length()) return point;
  const double along = x / room_->element_length;
  const std::size_t e = std::min(static_cast<std::size_t>(along), room_->elements - 1);
  const double xi = along - static_cast<double>(e);
  const BeamElement rail = room_->element(e, side);
  const Four shape = rail.deflection(xi);
  point.unknown = room_->unknowns_of(e, side);
  for (std::size_t k = 0; k < 4; ++k) point.value[k] = shape[static_cast<Eigen::Index>(k)];
  point.local = rail.local_flexibility(xi);
  return point;
}

std::vector<RailNodes> Line::rail_nodes() const {
  std::vector<RailNodes> nodes(room_->elements + 1, RailNodes{-1, -1, -1, -1});
  for (std::size_t side = 0; side < sides(); ++side)
    for (std::size_t n = 0; n < nodes.size(); ++n)
      std::copy_n(room_->nodes[side][n].begin(), 2, nodes[n].begin() + 2 * side);
  return nodes;
}

std::size_t Line::nearest_sleeper(double x) const {
  const auto last = static_cast<double>(sleepers() - 1);
  const double number = std::round(x / room_->parameters.track.spacing);
  return static_cast<std::size_t>(std::clamp(number, 0.0, last));
}

// What the pad gives to the sleeper; its inertia is none, so the rail gets the same.
double Line::seat_force(std::size_t i, const Vector& u, const Vector& v,
                        const std::array<Seat, 2>& seats, std::size_t side) const {
  const Sleeper& sleeper = room_->sleepers.at(i);
  const Kelvin& pad = sleeper.pad.at(side);
  const auto of = [](const Kelvin& one, const Vector& y, double given) {
    const auto [rail, below, none] = one.unknown;
    return (below >= 0 ? y[below] : given) - (rail >= 0 ? y[rail] : 0.0);
  };
  const Seat& seat = seats.at(side);
  // Over a run-in all is as much stiffer as the knee comes earlier.
  const double knee = room_->parameters.pad.knee / room_->run_in(sleeper.x);
  const double pressed = of(pad, u, seat.height), rate = of(pad, v, seat.rate);
  const double stiffer = sleeper.beyond.at(side) * std::max(0.0, pressed - knee);
  if (room_->parameters.pad.uplift) {
    const double preload = room_->preload(i, side);
    const double whole = pressed + preload / pad.stiffness;  // m, of the pad without any force
    return Stop{{}, 0, pad.stiffness, pad.damping}.force(whole, rate) - preload + stiffer;
  }
  double across = 0;
  if (sleeper.across_stiffness != 0) {
    const Kelvin& pad_across = sleeper.pad.at(1 - side);
    const Seat& other = seats.at(1 - side);
    across = sleeper.across_stiffness * of(pad_across, u, other.height) +
             sleeper.across_damping * of(pad_across, v, other.rate);
  }
  return pad.stiffness * pressed + pad.damping * rate + stiffer + across;
}

double Line::ground_force(std::size_t i, const Vector& u, const Vector& v, const Seat& seat,
                          std::size_t side) const {
  const Sleeper& sleeper = room_->sleepers.at(i);
  const Kelvin& lowest = sleeper.lowest.at(side);
  if (sleeper.on[side].empty()) return 0;  // it hangs
  double height = 0, rate = 0;
  for (const auto& [unknown, share] : sleeper.on[side])
    height += share * u[unknown], rate += share * v[unknown];
  return lowest.stiffness * (seat.height - height) + lowest.damping * (seat.rate - rate);
}

std::int32_t Line::ground_stop(std::size_t i, std::size_t side) const {
  return room_->sleepers.at(i).stop.at(side);
}

std::array<double, 2> Line::ground_spring(std::size_t i, std::size_t side) const {
  const Kelvin& lowest = room_->sleepers.at(i).lowest.at(side);
  const std::int32_t number = ground_stop(i, side);
  if (number < 0) return {lowest.stiffness, lowest.damping};
  const Stop& stop = stops()[static_cast<std::size_t>(number)];
  return {stop.stiffness, stop.damping};
}

// The linear part: that beyond a knee, or of a sleeper that hangs, is a stop.
void Line::add_seats(const std::vector<Seat>& seats, Vector& to) const {
  require(seats.size() == this->seats(), "one seat for each rail on a sleeper that is moved");
  const bool ground = room_->parameters.moves == MovedPart::ground;
  for (std::size_t k = 0; k < seats.size(); ++k) {
    const Sleeper& sleeper = room_->sleepers[first_moved() + k / sides()];
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
    for (const auto& [unknown, share] : sleeper.on[k % sides()]) to[unknown] += share * force;
  }
}

// The element's own end moment is exact for its loads at nodes; of a bed's force between nodes it
// has the consistent share.
double Line::bending_moment(double x, const Vector& u, std::size_t side) const {
  const Room& room = *room_;
  const auto node = static_cast<std::size_t>(std::llround(x / room.element_length));
  require(node >= 1 && node <= room.elements, "a bending moment is asked for left of a node");
  const BeamElement rail = room.element(node - 1, side);
  Matrix4 k = rail.stiffness();
  if (room.parameters.track.support == Support::continuous)
    k += room.parameters.track.bed_stiffness *
         room.bed_factor((static_cast<double>(node) - 0.5) * room.element_length, side) *
         rail.bed();
  const auto unknown = room.unknowns_of(node - 1, side);
  Four ends = Four::Zero();
  for (int i = 0; i < 4; ++i)
    if (unknown[static_cast<std::size_t>(i)] >= 0)
      ends[i] = u[unknown[static_cast<std::size_t>(i)]];
  return (k * ends)[3];
}

}  // namespace trackbed::track
