// Load of passing axles on a rail seat: closed forms, or a measured table.
// The rail is not computed: its bending is included in the shape of the load, so that the seat load
// does not depend on the settlement of sleepers.
#include "trackbed/track/seat_load.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "trackbed/core/error.hpp"
#include "trackbed/input/table.hpp"

namespace trackbed::track {

namespace {

// Deflection of an infinite Euler-Bernoulli beam on a Winkler bed (Winkler 1867; Zimmermann 1888),
// normalised to 1 below the load. s in m, b in 1/m.
//   f(s) = exp(-b|s|)(cos b|s| + sin b|s|),  b = (k/(4 E I))^(1/4),  1/m
// with k the stiffness of the bed per length of rail, Pa, and E I of the rail, N m^2. The seat load
// is the bed's reaction over one spacing, hence the same shape; it lifts beyond b|s| = 3 pi/4.
double winkler(double s, double b) {
  const double u = b * std::abs(s);
  return std::exp(-u) * (std::cos(u) + std::sin(u));
}

}  // namespace

// A table is checked when it is read, by every rank: `at` relies on increasing times.
SeatLoad::SeatLoad(const SeatLoadParameters& parameters, double spacing, std::size_t sleepers)
    : parameters_(parameters), spacing_(spacing) {
  if (!parameters.is_table()) return;
  std::vector<std::string> names = {"time_s"};
  if (parameters.kind == SeatLoadKind::table) names.emplace_back("force_N");
  const std::vector<std::string> sides = parameters.gauge > 0
                                             ? std::vector<std::string>{"_left", "_right"}
                                             : std::vector<std::string>{""};
  for (std::size_t i = 0; parameters.kind == SeatLoadKind::seats && i < sleepers; ++i)
    for (const std::string& side : sides) names.push_back(fmt::format("sleeper_{}{}", i, side));
  forces_ = input::read_table(parameters.file, names, "time_s");
  times_ = std::move(forces_.front());
  forces_.erase(forces_.begin());
  if (times_.size() < 2)
    throw InputError({fmt::format("{}: needs at least two rows", parameters.file)});
}

// Outside of the measured time the load is zero.
double SeatLoad::column(std::size_t number, double time) const {
  const std::vector<double>& forces = forces_.at(number);
  if (time < times_.front() || time > times_.back()) return 0;
  const auto after = std::upper_bound(times_.begin(), times_.end(), time) - times_.begin();
  const auto hi = std::min(static_cast<std::size_t>(after), times_.size() - 1), lo = hi - 1;
  const double fraction = (time - times_[lo]) / (times_[hi] - times_[lo]);
  return forces[lo] + fraction * (forces[hi] - forces[lo]);
}

double SeatLoad::left_excess(double time, std::size_t sleeper) const {
  if (parameters_.gauge == 0) return 0;
  return (column(2 * sleeper, time) - column(2 * sleeper + 1, time)) / 2;
}

// Local and without state: times may be evaluated in any order.
double SeatLoad::at(double x, double time, std::size_t sleeper) const {
  if (parameters_.is_table()) {
    // The loads travel unchanged: the load at x equals that at x = 0 a time x/speed earlier. A
    // table of seats has a column for each sleeper.
    if (parameters_.kind == SeatLoadKind::table) return column(0, time - x / parameters_.speed);
    if (parameters_.gauge == 0) return column(sleeper, time);
    return column(2 * sleeper, time) + column(2 * sleeper + 1, time);
  }
  // Axles superpose, as on a linear bed. s: distance of the axle from this sleeper, m.
  double sum = 0;
  for (const double behind : parameters_.axles) {
    const double s = parameters_.start + parameters_.speed * time - behind - x;
    sum += parameters_.kind == SeatLoadKind::winkler
               ? winkler(s, parameters_.decay)
               : std::pow(parameters_.ratio, (s / spacing_) * (s / spacing_));
  }
  return parameters_.peak_load() * sum;
}

// The bed's reaction on a spacing L directly below a wheel load Q is Q b L/2, see `winkler`.
std::vector<AxleLoad> SeatLoad::axles(double time) const {
  const double force = 2 * parameters_.peak_load() / (parameters_.decay * spacing_);
  std::vector<AxleLoad> all;
  for (const double behind : parameters_.axles)
    all.push_back({parameters_.start + parameters_.speed * time - behind, force});
  return all;
}

// Loads at the start of a table at time 0 or before are part of the static equilibrium or, on a
// bed, are applied suddenly like any load that starts with a stage, which checks them.
std::vector<std::string> SeatLoad::jumps(double first_x, double last_x, double time) const {
  constexpr double unnoticed = 0.02;  // of the largest load
  if (!parameters_.is_table()) return {};
  double largest = 0, first = 0, last = 0;  // N
  const auto take = [](double& kept, double force) {
    if (std::abs(force) > std::abs(kept)) kept = force;
  };
  for (const std::vector<double>& forces : forces_) {
    for (const double force : forces) take(largest, force);
    take(first, forces.front()), take(last, forces.back());
  }
  const bool shared = parameters_.kind == SeatLoadKind::table;
  const double begin = times_.front() + (shared ? last_x / parameters_.speed : 0);
  const double end = times_.back() + (shared ? first_x / parameters_.speed : 0);
  std::vector<std::string> found;
  if (std::abs(first) > unnoticed * std::abs(largest) && begin > 0 && begin < time)
    found.push_back(
        fmt::format("the load of a sleeper jumps from 0 to {:g} N (first row) at {:g} s; "
                    "let the table begin with 0",
                    first, begin));
  if (std::abs(last) > unnoticed * std::abs(largest) && end < (1 - 1e-9) * time)
    found.push_back(
        fmt::format("the load of a sleeper drops from {:g} N (last row) to 0 at {:g} s; "
                    "let the last row be 0, or, if the duration is given, let the table reach to "
                    "the end of the passage ({:g} s)",
                    last, end, time));
  return found;
}

double SeatLoad::duration(double last_x) const {
  // m beyond the last sleeper. With the default decay or ratio less than 2 % of the peak remains
  // there; on a softer bed (a decay of 1 per m: 4 %) a larger part of the load is cut off.
  constexpr double run_out = 3;
  if (parameters_.kind == SeatLoadKind::seats) return times_.back();
  if (parameters_.kind == SeatLoadKind::table) return times_.back() + last_x / parameters_.speed;
  double last = 0;  // without axles, of a stage that is done
  for (const double behind : parameters_.axles) last = std::max(last, behind);
  return (last_x + run_out + last - parameters_.start) / parameters_.speed;
}

}  // namespace trackbed::track
