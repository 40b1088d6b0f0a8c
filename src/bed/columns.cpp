// Columns of loose stones. Each stone depends only on its number and the seed, each column only on
// its own stones: any rank can build any part, in time proportional to that part.
//
// Cost: in a plane O(1) per stone; in space `tries` places, each against all stones of the column
// below, which is O(n^2) in the stones of one column and does not grow with the bed's area. A
// cylinder is one column: some thousand stones.
// Rejected forms are in docs/decisions/packing.md.
#include "columns.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "trackbed/core/error.hpp"
#include "trackbed/core/hash.hpp"

namespace trackbed::bed {

namespace {

constexpr double gap = 1.02;  // room over bound, so that rounding never makes stones touch

// In space a column is this many largest stones wide, and each stone tries so many places: about
// three times denser than columns as wide as a stone, whose small stones stand in empty shafts.
constexpr std::int64_t widest = 4;
constexpr std::uint64_t tries = 24;

// Random numbers of stone i, by what they are for.
// A hash of seed, stone and use: no state, so no order in which numbers have to be drawn.
enum class Use : std::uint64_t { x, y, turn, axis, twist, count };
double random(std::uint64_t seed, std::int64_t stone, Use use) {
  const auto key = static_cast<std::uint64_t>(stone) * static_cast<std::uint64_t>(Use::count);
  return uniform(seed, key + static_cast<std::uint64_t>(use));
}

// Even over all rotations (Shoemake 1992, Graphics Gems III, III.6), or about y alone.
// In a plane a stone may only turn about y.
Quat attitude(Dimension dimension, std::uint64_t seed, std::int64_t stone) {
  const double turn = 2 * std::numbers::pi * random(seed, stone, Use::turn);
  if (dimension == Dimension::plane) return Quat(Eigen::AngleAxisd(turn, Vec3::UnitY()));
  const double share = random(seed, stone, Use::axis);
  const double twist = 2 * std::numbers::pi * random(seed, stone, Use::twist);
  const double a = std::sqrt(1 - share), b = std::sqrt(share);
  return {b * std::cos(twist), a * std::sin(turn), a * std::cos(turn), b * std::sin(twist)};
}

// Whole columns only, each at least as wide as the largest stone with its room.
std::int64_t fitting(double length, double width, const char* what) {
  const auto columns = static_cast<std::int64_t>(length / width);
  if (columns < 1)
    throw InputError(
        {fmt::format("bed.{}: the bed is {:.4g} m wide, narrower than the ball around its largest "
                     "stone ({:.4g} m, see bed.sieve); make it wider or the stones smaller",
                     what, length, width)});
  return columns;
}

// Bundles `widest` narrow columns into one; a bed too narrow for that is one column.
std::int64_t wider(std::int64_t columns) { return std::max<std::int64_t>(1, columns / widest); }

// Where a ball of radius r over (x, y) comes to rest on those below it.
// The floor is z = 0. Of two balls that touch, the distance of centres is r + R:
//   (z - Z)^2 = (r + R)^2 - dx^2 - dy^2;   a ball beside the line of fall gives no real root.
double rest_on(const std::vector<geom::Sphere>& balls, double x, double y, double r) {
  double z = r;
  for (const geom::Sphere& ball : balls) {
    const double dx = x - ball.centre.x(), dy = y - ball.centre.y(), reach = r + ball.radius;
    const double rise = reach * reach - dx * dx - dy * dy;
    if (rise > 0) z = std::max(z, ball.centre.z() + std::sqrt(rise));
  }
  return z;
}

}  // namespace

// A Feistel network permutes the numbers of 2 h bits; numbers beyond `count` are sent on until they
// fall below (Black, Rogaway 2002, doi:10.1007/3-540-45760-7_9). At most 4 rounds trips on average.
// Each round is invertible whatever its function is, so the whole is a permutation; `mix` makes it
// look random. The domain has at most four times as many numbers as wanted: it is the smallest
// power of 4 that holds them.
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

// The number of stones follows from the solid volume wanted,
//   N = A h (1 - porosity)/mean volume,   A the floor
// in a plane with areas per unit of thickness.
Columns::Columns(const BedParameters& parameters, const dem::Domain& domain, const Mix& mix,
                 double share)
    : mix_(mix),
      dimension_(domain.dimension),
      seed_(static_cast<std::uint64_t>(parameters.seed)),
      share_(share) {
  const bool plane = dimension_ == Dimension::plane;
  const double length = parameters.x[1] - parameters.x[0];
  const double width = parameters.y[1] - parameters.y[0];
  const double floor = plane ? length : parameters.container_in(domain).area();
  const double solid = floor * parameters.height * (1 - parameters.porosity);
  stones_ = std::max<std::int64_t>(1, std::llround(solid / mix.mean_volume()));
  const double cell = 2 * gap * share * mix.largest_bound();
  along_ = fitting(length, cell, "x");
  across_ = plane ? 1 : fitting(width, cell, "y");
  if (!plane) along_ = wider(along_), across_ = wider(across_);
  if (parameters.container == ContainerKind::cylinder) {
    along_ = across_ = 1;
    clear_ = parameters.container_in(domain).clear_radius();
  }
  low_ = {parameters.x[0], plane ? 0 : parameters.y[0], 0};
  size_ = {length / static_cast<double>(along_), plane ? 0 : width / static_cast<double>(across_),
           0};
}

// Column c has the stones from c N/n to (c + 1) N/n, rounded down: each stone in exactly one
// column, and columns alike to one stone.
double Columns::build(std::int64_t c, std::vector<dem::NewParticle>& to) const {
  const Vec3 foot = low_ + Vec3(static_cast<double>(c / across_) * size_.x(),
                                static_cast<double>(c % across_) * size_.y(), 0);
  std::vector<geom::Sphere> balls;
  double top = 0;
  for (std::int64_t i = c * stones_ / count(); i < (c + 1) * stones_ / count(); ++i) {
    dem::NewParticle stone = make(i);
    const double room = gap * share_ * mix_.bound({stone.shape, stone.scale});
    const Vec3 at = dimension_ == Dimension::plane ? on_top(i, room, top) : lowest(i, room, balls);
    balls.push_back({at, room});
    top = std::max(top, at.z() + room);
    stone.position = foot + at;
    to.push_back(stone);
  }
  return top;
}

dem::NewParticle Columns::make(std::int64_t i) const {
  // Sizes are spread evenly over the grading and shuffled: the bed has the sieve curve itself, not
  // a sample of it that scatters with the number of stones.
  const auto count = static_cast<std::uint64_t>(stones_);
  const Draw draw = mix_.draw(shuffled(static_cast<std::uint64_t>(i), count, seed_), count);
  dem::NewParticle stone;
  stone.id = i;
  stone.shape = draw.shape;
  stone.scale = draw.scale;
  stone.attitude = attitude(dimension_, seed_, i);
  return stone;
}

// Above all stones of the column, anywhere across it.
// Anywhere where its circle stays within the column, so that neighbouring columns cannot meet.
Vec3 Columns::on_top(std::int64_t i, double room, double top) const {
  return {room + random(seed_, i, Use::x) * (size_.x() - 2 * room), 0, top + room};
}

// The lowest of several places on the stones of the column.
// A seed per try. Balls of the bound stand for the stones: far looser than a packing, but nothing
// has to be known of shapes, and the fall packs them.
Vec3 Columns::lowest(std::int64_t i, double room, const std::vector<geom::Sphere>& balls) const {
  Vec3 best = Vec3::Constant(std::numeric_limits<double>::infinity());
  for (std::uint64_t k = 0; k < tries; ++k) {
    double x = room + random(mix(seed_) + k, i, Use::x) * (size_.x() - 2 * room);
    double y = room + random(mix(seed_) + k, i, Use::y) * (size_.y() - 2 * room);
    if (clear_ > 0) std::tie(x, y) = in_circle(i, room, mix(seed_) + k);
    const double z = rest_on(balls, x, y, room);
    if (z < best.z()) best = {x, y, z};
  }
  return best;
}

// Even over the circle that leaves the stone room within the cylinder: r = R sqrt(u).
std::pair<double, double> Columns::in_circle(std::int64_t i, double room,
                                             std::uint64_t seed) const {
  const double turn = 2 * std::numbers::pi * random(seed, i, Use::x);
  const double r = std::max(0.0, clear_ - room) * std::sqrt(random(seed, i, Use::y));
  return {size_.x() / 2 + r * std::cos(turn), size_.y() / 2 + r * std::sin(turn)};
}

}  // namespace trackbed::bed
