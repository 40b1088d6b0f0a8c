// Extremes along a track alone. All ranks hold the same ones.
#include "trackbed/observe/passage_envelope.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace trackbed::observe {

namespace {

// m, of all sleepers, or of whole metres if there are none.
std::vector<double> monitored(const track::Line& line) {
  std::vector<double> x(line.sleepers());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = line.sleeper_x(i);
  if (x.empty())
    for (double at = 0; at <= line.length(); ++at) x.push_back(at);
  return x;
}

}  // namespace

PassageEnvelope::PassageEnvelope(const track::Line& line)
    : line_(line),
      rail_{"envelope/rail/displacement", "m", "vertical displacement, up positive", {}, {}},
      sleeper_{"envelope/sleeper/displacement", "m", "vertical displacement, up positive", {}, {}},
      seat_{"envelope/sleeper/seat_force",
            "N",
            "force of the pad on the sleeper, or the seat load, down positive",
            {},
            {}} {
  for (const double x : monitored(line))
    for (std::size_t side = 0; side < line.sides(); ++side) {
      x_.push_back(x);
      rail_points_.push_back(line.at(x, side));
    }
  constexpr double none = std::numeric_limits<double>::infinity();
  const std::size_t of_sleepers = line.sleepers() * line.sides();
  for (auto [range, width] :
       {std::pair(&rail_, x_.size()), {&sleeper_, of_sleepers}, {&seat_, of_sleepers}}) {
    range->least.assign(width, none);
    range->most.assign(width, -none);
  }
}

void PassageEnvelope::Range::update(std::size_t place, double value) {
  least[place] = std::min(least[place], value);
  most[place] = std::max(most[place], value);
}

void PassageEnvelope::update(const track::Passage& passage) {
  const track::Vector& u = passage.line_motion().displacement;
  for (std::size_t k = 0; k < x_.size(); ++k) rail_.update(k, rail_points_[k].deflection(u));
  for (std::size_t k = 0; k < seat_.least.size(); ++k) {
    const std::size_t sleeper = k / line_.sides(), side = k % line_.sides();
    sleeper_.update(k, u[line_.sleeper_unknown(sleeper, side)]);
    seat_.update(k, passage.on_sleeper(sleeper, side));
  }
}

// `x` follows from the deck and is for readers of results.
void PassageEnvelope::archive(io::Archive& a) {
  if (!a.reads()) a.rows("envelope/x", x_, {"m", "places along the track, sleepers if any"});
  for (Range* range : {&rail_, &sleeper_, &seat_}) {
    if (range->least.empty()) continue;
    a.rows(range->path + "_min", range->least,
           {range->unit, "smallest of all steps: " + range->meaning});
    a.rows(range->path + "_max", range->most,
           {range->unit, "largest of all steps: " + range->meaning});
  }
}

}  // namespace trackbed::observe
