#include "model/coupling/rail_ends.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace trackbed::model {

namespace {

constexpr std::size_t count = 3;   // of sleepers whose mean is taken: one may hang
constexpr double ahead = 3;        // m: a rail deflects less far before an axle
constexpr double different = 1.3;  // ratio; of the fitted springs of inputs/quickstart.toml 1.13
constexpr double least = 1e-5;     // m: less is no deflection by a train

// First sleeper of each of the four groups.
std::array<std::size_t, 4> groups(std::size_t before, std::size_t sleepers) {
  return {before, before - count, before + sleepers - count, before + sleepers};
}

// m, mean of all rails.
double displacement_above(const track::TrainOnBed& train, std::size_t sleeper) {
  const track::Line& line = train.line();
  double sum = 0;
  for (std::size_t side = 0; side < line.sides(); ++side)
    sum += train.passage().rail_displacement(line.sleeper_x(sleeper), side);
  return sum / static_cast<double>(line.sides());
}

// `bed` of zones, mean of sleepers of one end: as it is, and as it must be so that ballast springs
// and pads together become `times` as stiff; the latter is below 0 if no value does it.
struct Factors {
  double now = 0, wanted = 0;
};

Factors bed_factors(const track::LineParameters& line, std::size_t first, double times) {
  Factors mean;
  for (std::size_t k = 0; k < count; ++k) {
    const double x = line.track.sleeper_x(first + k);
    const double pad = line.pad.stiffness * line.track.factor(&track::TrackZone::pad, x, 0);
    const double bed = line.track.factor(&track::TrackZone::bed, x, 0);
    const double ballast = line.ballast.stiffness * bed;
    const double wanted = 1 / ((1 / pad + 1 / ballast) / times - 1 / pad);
    if (!(wanted > 0) || !std::isfinite(wanted)) return {bed, -1};
    mean.now += bed / count;
    mean.wanted += wanted / line.ballast.stiffness / count;
  }
  return mean;
}

std::string remedy(const Factors& bed, bool stiffer) {
  if (bed.wanted < 0)
    return fmt::format("make the springs {} (`bed` of a [[track.zone]], [ballast])",
                       stiffer ? "stiffer" : "softer");
  return fmt::format("give `bed` of about {:.2g} instead of {:.3g} in a [[track.zone]] there",
                     bed.wanted, bed.now);
}

}  // namespace

// A bed at rest with its rail sinks before the train comes, and is no measure of its stiffness.
void RailEnds::observe(const track::TrainOnBed& train, std::size_t sleepers) {
  const track::Line& line = train.line();
  const std::size_t first = line.first_moved();
  before_.resize(4 * count, 0.0), lowest_.resize(4 * count, 0.0);
  if (sleepers < count || first < count || first + sleepers + count > line.sleepers()) return;
  double front = train.passage().wheel_x(0);
  last_axle_ = front;
  for (std::size_t i = 0; i < train.train().wheels().size(); ++i)
    last_axle_ = std::min(last_axle_, train.passage().wheel_x(i)),
    front = std::max(front, train.passage().wheel_x(i));
  const bool coming = front < line.sleeper_x(first - count) - ahead;
  const auto begins = groups(first, sleepers);
  for (std::size_t k = 0; k < before_.size(); ++k) {
    const double now = displacement_above(train, begins.at(k / count) + k % count);
    if (coming) before_[k] = lowest_[k] = now;
    lowest_[k] = std::min(lowest_[k], now);
  }
}

// Of a beam on an elastic foundation the deflection is proportional to the stiffness to the power
// of -3/4 (Zimmermann, 1888); the foundation consists of pads and ballast. Within the run-in of the
// track, springs are stiffer than given.
std::vector<std::string> RailEnds::warnings(const track::LineParameters& line, std::size_t before,
                                            std::size_t sleepers) const {
  std::vector<std::string> sentences;
  if (lowest_.empty() || before < count || sleepers < count) return sentences;
  const track::TrackParameters& track = line.track;
  const auto begins = groups(before, sleepers);
  const auto mean = [&](std::size_t part) {
    double sum = 0;
    for (std::size_t k = part * count; k < (part + 1) * count; ++k) sum += before_[k] - lowest_[k];
    return sum / static_cast<double>(count);
  };
  for (const std::size_t end : {0, 1}) {
    const std::size_t springs = begins.at(2 * end + 1);
    const double low = track.sleeper_x(springs), high = track.sleeper_x(springs + count - 1);
    const bool passed = last_axle_ > high;
    if (!passed || low < track.run_in || high > track.length - track.run_in) continue;
    const double on_stones = mean(2 * end), on_springs = mean(2 * end + 1);
    if (on_stones < least || on_springs < least) continue;
    const double ratio = on_springs / on_stones;
    if (ratio <= different && ratio >= 1 / different) continue;
    const Factors bed = bed_factors(line, springs, std::pow(ratio, 4.0 / 3));
    sentences.push_back(fmt::format(
        "the track on springs does not match the bed: at the {} of the bed the rail deflects under "
        "the train by {:.2g} mm above the {} {} sleepers on stones and by {:.2g} mm above the {} "
        "ones on springs (ratio {:.3g}, usually at most {:g}); if they are not meant to be a "
        "transition and no sleeper hangs above the stones, {}",
        end == 0 ? "start" : "end", 1e3 * on_stones, end == 0 ? "first" : "last", count,
        1e3 * on_springs, end == 0 ? "previous" : "next", std::max(ratio, 1 / ratio), different,
        remedy(bed, ratio > 1)));
  }
  return sentences;
}

void RailEnds::archive(io::Archive& a) {
  if (!a.has("lowest", !lowest_.empty())) return;
  a("before", before_,
    {"m",
     "displacement of the rail before the train comes, above three sleepers each: the first of the "
     "bed, those before, the last of the bed, those behind"});
  a("lowest", lowest_, {"m", "lowest displacement of the rail up to now, above the same"});
  a("last_axle", last_axle_, {"m", "place of the last axle, from the start of the track"});
}

}  // namespace trackbed::model
