#include "model/coupling/rail_ends.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace trackbed::model {

namespace {

constexpr std::size_t count = 3;   // of sleepers whose mean is taken: one may hang
constexpr double different = 1.3;  // ratio; of the fitted springs of inputs/quickstart.toml 1.08
constexpr double least = 1e-5;     // m: less is no deflection by a train

// m, mean of all rails.
double displacement_above(const track::TrainOnBed& train, std::size_t sleeper) {
  const track::Line& line = train.line();
  double sum = 0;
  for (std::size_t side = 0; side < line.sides(); ++side)
    sum += train.passage().rail_displacement(line.sleeper_x(sleeper), side);
  return sum / static_cast<double>(line.sides());
}

}  // namespace

void RailEnds::observe(const track::TrainOnBed& train, std::size_t sleepers) {
  const std::size_t first = train.line().first_moved(), behind = first + sleepers;
  lowest_.resize(4 * count, 0.0);
  if (sleepers < count || first < count || behind + count > train.line().sleepers()) return;
  const std::array<std::size_t, 4> begins{first, first - count, behind - count, behind};
  for (std::size_t part = 0; part < begins.size(); ++part)
    for (std::size_t k = 0; k < count; ++k) {
      double& lowest = lowest_[part * count + k];
      lowest = std::min(lowest, displacement_above(train, begins[part] + k));
    }
}

// Of a beam on an elastic foundation the deflection is proportional to the stiffness to the power
// of -3/4 (Zimmermann, 1888).
std::vector<std::string> RailEnds::warnings() const {
  std::vector<std::string> sentences;
  if (lowest_.empty()) return sentences;
  const auto mean = [&](std::size_t part) {
    const auto from = lowest_.begin() + static_cast<std::ptrdiff_t>(part * count);
    return -std::accumulate(from, from + count, 0.0) / count;
  };
  for (const std::size_t end : {0, 1}) {
    const double on_stones = mean(2 * end), on_springs = mean(2 * end + 1);
    if (on_stones < least || on_springs < least) continue;
    const double ratio = on_springs / on_stones;
    if (ratio <= different && ratio >= 1 / different) continue;
    sentences.push_back(fmt::format(
        "the track on springs does not match the bed: at the {} of the bed the rail deflects under "
        "the train by {:.2g} mm above the {} {} sleepers on stones and by {:.2g} mm above the {} "
        "ones on springs (ratio {:.2g}, usually at most {:g}); if they are not meant to be a "
        "transition, make "
        "the springs about {:.2g} times as stiff (`bed` of a [[track.zone]], or "
        "ballast.stiffness)",
        end == 0 ? "start" : "end", 1e3 * on_stones, end == 0 ? "first" : "last", count,
        1e3 * on_springs, end == 0 ? "previous" : "next", std::max(ratio, 1 / ratio), different,
        std::pow(ratio, 4.0 / 3)));
  }
  return sentences;
}

void RailEnds::archive(io::Archive& a) {
  if (!a.has("lowest", !lowest_.empty())) return;
  a("lowest", lowest_,
    {"m",
     "lowest displacement of the rail up to now, of three sleepers each: the first of the bed, "
     "those before, the last of the bed, those behind"});
}

}  // namespace trackbed::model
