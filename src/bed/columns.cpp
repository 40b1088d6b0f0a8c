// Columns of loose stones. Each stone depends only on its number and the seed, each column only on
// its own stones: any rank can build any part, in time proportional to that part.
#include "columns.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"

namespace trackbed::bed {

namespace {

constexpr double gap = 1.02;  // room over bound, so that rounding never makes stones touch

// Random numbers of stone i, by what they are for.
enum class Use : std::uint64_t { x, y, turn, axis, twist, count };
double random(std::uint64_t seed, std::int64_t stone, Use use) {
  const auto key = static_cast<std::uint64_t>(stone) * static_cast<std::uint64_t>(Use::count);
  return uniform(seed, key + static_cast<std::uint64_t>(use));
}

// Even over all rotations (Shoemake 1992, Graphics Gems III, III.6), or about y alone.
Quat attitude(Dimension dimension, std::uint64_t seed, std::int64_t stone) {
  const double turn = 2 * std::numbers::pi * random(seed, stone, Use::turn);
  if (dimension == Dimension::plane) return Quat(Eigen::AngleAxisd(turn, Vec3::UnitY()));
  const double share = random(seed, stone, Use::axis);
  const double twist = 2 * std::numbers::pi * random(seed, stone, Use::twist);
  const double a = std::sqrt(1 - share), b = std::sqrt(share);
  return {b * std::cos(twist), a * std::sin(turn), a * std::cos(turn), b * std::sin(twist)};
}

std::int64_t fitting(double length, double width, const char* what) {
  const auto columns = static_cast<std::int64_t>(length / width);
  if (columns < 1)
    throw InputError(
        {fmt::format("bed.{} is {:.4g} m wide, narrower than the largest stone ({:.4g} m)", what,
                     length, width)});
  return columns;
}

}  // namespace

// A Feistel network permutes the numbers of 2 h bits; numbers beyond `count` are sent on until they
// fall below (Black, Rogaway 2002, doi:10.1007/3-540-45760-7_9). At most 4 rounds trips on average.
std::uint64_t shuffled(std::uint64_t i, std::uint64_t count, std::uint64_t seed) {
  constexpr std::uint64_t rounds = 4;
  unsigned half = 1;
  while ((std::uint64_t{1} << (2 * half)) < count) ++half;
  const std::uint64_t mask = (std::uint64_t{1} << half) - 1;
  do {
    std::uint64_t left = i >> half, right = i & mask;
    for (std::uint64_t round = 0; round < rounds; ++round) {
      const std::uint64_t next = left ^ (mix(seed ^ mix(right * rounds + round)) & mask);
      left = right, right = next;
    }
    i = left << half | right;
  } while (i >= count);
  return i;
}

Columns::Columns(const BedParameters& parameters, const dem::Domain& domain, const Mix& mix)
    : mix_(mix), dimension_(domain.dimension), seed_(static_cast<std::uint64_t>(parameters.seed)) {
  const bool plane = dimension_ == Dimension::plane;
  const double length = parameters.x[1] - parameters.x[0];
  const double width = parameters.y[1] - parameters.y[0];
  const double solid = length * (plane ? 1 : width) * parameters.height * (1 - parameters.porosity);
  stones_ = std::max<std::int64_t>(1, std::llround(solid / mix.mean_volume()));
  const double cell = 2 * gap * mix.largest_bound();
  along_ = fitting(length, cell, "x");
  across_ = plane ? 1 : fitting(width, cell, "y");
  low_ = {parameters.x[0], plane ? 0 : parameters.y[0], 0};
  size_ = {length / static_cast<double>(along_), plane ? 0 : width / static_cast<double>(across_),
           0};
}

double Columns::build(std::int64_t c, std::vector<dem::NewParticle>& to) const {
  Vec3 foot = low_ + Vec3(static_cast<double>(c / across_) * size_.x(),
                          static_cast<double>(c % across_) * size_.y(), 0);
  for (std::int64_t i = c * stones_ / count(); i < (c + 1) * stones_ / count(); ++i)
    foot.z() = place(i, foot, to);
  return foot.z();
}

// Puts stone i on top of what its column holds, anywhere across the column; returns the new top.
double Columns::place(std::int64_t i, const Vec3& foot, std::vector<dem::NewParticle>& to) const {
  // Sizes are spread evenly over the grading and shuffled: the bed has the sieve curve itself, not
  // a sample of it that scatters with the number of stones.
  const auto count = static_cast<std::uint64_t>(stones_);
  const std::uint64_t place = shuffled(static_cast<std::uint64_t>(i), count, seed_);
  const Draw draw = mix_.draw((static_cast<double>(place) + 0.5) / static_cast<double>(stones_));
  const double room = gap * mix_.bound(draw);
  dem::NewParticle stone;
  stone.id = i;
  stone.shape = draw.shape;
  stone.scale = draw.scale;
  stone.position = foot + Vec3(room + random(seed_, i, Use::x) * (size_.x() - 2 * room), 0, room);
  if (dimension_ == Dimension::space)
    stone.position.y() += room + random(seed_, i, Use::y) * (size_.y() - 2 * room);
  stone.attitude = attitude(dimension_, seed_, i);
  to.push_back(stone);
  return foot.z() + 2 * room;
}

}  // namespace trackbed::bed
