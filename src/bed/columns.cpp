// Columns of loose stones. Each stone depends only on its number and the seed, each column only on
// its own stones, so any rank can generate any part, in time proportional to that part.
//
// Cost: in a plane O(1) per stone; in space `tries` trial positions, each compared with the upper
// stones near it.
// Rejected alternatives are in docs/decisions/packing.md.
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

constexpr double gap = 1.02;  // clearance over bound, so that rounding never causes contact

// In space a column is this many largest stones wide, and each stone has this many trial positions:
// about three times denser than columns as wide as a stone, in which small stones are far apart.
constexpr std::int64_t widest = 4;
constexpr std::uint64_t tries = 24;

// Random numbers of stone i for a given use: a hash of seed, stone and use, without state, and so
// independent of the order of calls.
enum class Use : std::uint64_t { x, y, turn, axis, twist, count };
double random(std::uint64_t seed, std::int64_t stone, Use use) {
  const auto key = static_cast<std::uint64_t>(stone) * static_cast<std::uint64_t>(Use::count);
  return uniform(seed, key + static_cast<std::uint64_t>(use));
}

// Uniform over all rotations (Shoemake 1992, Graphics Gems III, III.6), or about y alone in a
// plane.
Quat attitude(Dimension dimension, std::uint64_t seed, std::int64_t stone) {
  const double turn = 2 * std::numbers::pi * random(seed, stone, Use::turn);
  if (dimension == Dimension::plane) return Quat(Eigen::AngleAxisd(turn, Vec3::UnitY()));
  const double fraction = random(seed, stone, Use::axis);
  const double twist = 2 * std::numbers::pi * random(seed, stone, Use::twist);
  const double a = std::sqrt(1 - fraction), b = std::sqrt(fraction);
  return {b * std::cos(twist), a * std::sin(turn), a * std::cos(turn), b * std::sin(twist)};
}

// Whole columns only, each at least as wide as the largest stone with its clearance.
std::int64_t fitting(double length, double width, const char* what) {
  const auto columns = static_cast<std::int64_t>(length / width);
  if (columns < 1)
    throw InputError(
        {fmt::format("bed.{}: the bed is {:.4g} m long in this direction, less than the diameter "
                     "of the bounding sphere of its largest stone with clearance ({:.4g} m, from "
                     "the largest sieve); make the bed larger or the stones smaller",
                     what, length, width)});
  return columns;
}

// Cells of the floor of a column of `stones`, along each side: some four stones wide, if the column
// is as high as it is wide.
std::int64_t cells_of(std::int64_t stones) {
  return std::clamp<std::int64_t>(std::llround(std::cbrt(static_cast<double>(stones)) / 4), 1, 64);
}

// Combines `widest` narrow columns into one; a bed too narrow for that is one column.
std::int64_t wider(std::int64_t columns) { return std::max<std::int64_t>(1, columns / widest); }

}  // namespace

Heap::Heap(const Vec3& size, std::int64_t cells)
    : width_{size.x() / static_cast<double>(cells), size.y() / static_cast<double>(cells)},
      cells_(cells),
      all_(static_cast<std::size_t>(cells * cells)) {}

// Two balls that touch are both above the cell below the place of contact. The tolerance keeps it
// for both, whatever the rounding.
template <class Visit>
void Heap::cells_below(double x, double y, double radius, Visit visit) const {
  constexpr double rounding = 1e-9;  // of a cell
  const auto number = [&](double at, double width) {
    return std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(at / width)), 0,
                                    cells_ - 1);
  };
  const double beyond = radius + rounding * std::max(width_[0], width_[1]);
  const std::int64_t first = number(x - beyond, width_[0]), last = number(x + beyond, width_[0]);
  const std::int64_t low = number(y - beyond, width_[1]), high = number(y + beyond, width_[1]);
  for (std::int64_t i = first; i <= last; ++i)
    for (std::int64_t j = low; j <= high; ++j) visit(static_cast<std::size_t>(i * cells_ + j));
}

// The highest top of this and all earlier balls states where the search may end.
void Heap::add(const geom::Sphere& ball) {
  const double x = ball.centre.x(), y = ball.centre.y(), top = ball.centre.z() + ball.radius;
  cells_below(x, y, ball.radius, [&](std::size_t number) {
    Cell& cell = all_[number];
    cell.x.push_back(x), cell.y.push_back(y), cell.z.push_back(ball.centre.z());
    cell.radius.push_back(ball.radius);
    cell.highest.push_back(cell.highest.empty() ? top : std::max(top, cell.highest.back()));
  });
}

double Heap::height_on(double x, double y, double r, double limit) const {
  double height = r;
  cells_below(x, y, r, [&](std::size_t number) {
    if (height < limit) height = height_on(all_[number], x, y, r, limit, height);
  });
  return height;
}

// For two spheres in contact the distance of centres is r + R:
//   (z - Z)^2 = (r + R)^2 - dx^2 - dy^2;   without a real root the spheres do not touch.
// So z is at most Z + R + r. From the latest ball, which is near the top, to earlier ones, several
// at once: those beyond the end of the search do not change the maximum.
double Heap::height_on(const Cell& cell, double x, double y, double r, double limit,
                       double height) {
  constexpr double rounding = 1e-9;  // of a height
  constexpr std::size_t at_once = 16;
  for (std::size_t end = cell.x.size();
       end > 0 && height < limit && (cell.highest[end - 1] + r) * (1 + rounding) > height;) {
    const std::size_t begin = end > at_once ? end - at_once : 0;
#pragma omp simd reduction(max : height)
    for (std::size_t i = begin; i < end; ++i) {
      const double dx = x - cell.x[i], dy = y - cell.y[i], reach = r + cell.radius[i];
      const double rise = reach * reach - dx * dx - dy * dy;
      const double on = cell.z[i] + std::sqrt(std::max(rise, 0.0));
      height = std::max(height, rise > 0 ? on : 0.0);
    }
    end = begin;
  }
  return height;
}

// A Feistel network permutes the numbers of 2 h bits; numbers beyond `count` are permuted again
// until they are below it (Black, Rogaway 2002, doi:10.1007/3-540-45760-7_9). At most 4 passes on
// average. Each round is invertible whatever its function is, so the whole is a permutation; `mix`
// makes it pseudo-random. The domain is the smallest power of 4 that is at least `count`, at most
// four times as large.
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

// The number of stones follows from the required solid volume,
//   N = A h (1 - porosity)/mean volume,   A: area of the floor,
// in a plane from areas per unit of thickness.
Columns::Columns(const BedParameters& parameters, const dem::Domain& domain, const Mix& mix,
                 double size_factor)
    : mix_(mix),
      dimension_(domain.dimension),
      seed_(static_cast<std::uint64_t>(parameters.seed)),
      size_factor_(size_factor) {
  const bool plane = dimension_ == Dimension::plane;
  const double length = parameters.x[1] - parameters.x[0];
  const double width = parameters.y[1] - parameters.y[0];
  const double floor = plane ? length : parameters.container_in(domain).area();
  const double solid = floor * parameters.height * (1 - parameters.porosity);
  stones_ = std::max<std::int64_t>(1, std::llround(solid / mix.mean_volume()));
  const double cell = 2 * gap * size_factor * mix.largest_bound();
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

// Column c has the stones from c N/n to (c + 1) N/n, rounded down: each stone belongs to one
// column, and the numbers in columns differ by one at most.
double Columns::build(std::int64_t c, std::vector<dem::NewParticle>& to) const {
  const Vec3 foot = low_ + Vec3(static_cast<double>(c / across_) * size_.x(),
                                static_cast<double>(c % across_) * size_.y(), 0);
  Heap heap(size_, cells_of(stones_ / count()));
  double top = 0;
  for (std::int64_t i = c * stones_ / count(); i < (c + 1) * stones_ / count(); ++i) {
    dem::NewParticle stone = make(i);
    const double clearance = gap * size_factor_ * mix_.bound({stone.shape, stone.scale});
    const Vec3 at =
        dimension_ == Dimension::plane ? on_top(i, clearance, top) : lowest(i, clearance, heap);
    heap.add({at, clearance});
    top = std::max(top, at.z() + clearance);
    stone.position = foot + at;
    to.push_back(stone);
  }
  return top;
}

dem::NewParticle Columns::make(std::int64_t i) const {
  // Sizes are evenly distributed over the grading and shuffled, so that the bed has the sieve curve
  // itself, without the scatter of a random sample.
  const auto count = static_cast<std::uint64_t>(stones_);
  const Draw draw = mix_.draw(shuffled(static_cast<std::uint64_t>(i), count, seed_), count);
  dem::NewParticle stone;
  stone.id = i;
  stone.shape = draw.shape;
  stone.scale = draw.scale;
  stone.attitude = attitude(dimension_, seed_, i);
  return stone;
}

// Above all stones of the column, at any x where its circle stays within the column, so that stones
// of neighbouring columns do not touch.
Vec3 Columns::on_top(std::int64_t i, double clearance, double top) const {
  return {clearance + random(seed_, i, Use::x) * (size_.x() - 2 * clearance), 0, top + clearance};
}

// The lowest of several trial positions on the stones of the column, with one seed per trial.
// Bounding spheres represent the stones: far looser than a packing, but independent of their
// shapes; the fall compacts them.
Vec3 Columns::lowest(std::int64_t i, double clearance, const Heap& heap) const {
  Vec3 best = Vec3::Constant(std::numeric_limits<double>::infinity());
  for (std::uint64_t k = 0; k < tries; ++k) {
    double x = clearance + random(mix(seed_) + k, i, Use::x) * (size_.x() - 2 * clearance);
    double y = clearance + random(mix(seed_) + k, i, Use::y) * (size_.y() - 2 * clearance);
    if (clear_ > 0) std::tie(x, y) = in_circle(i, clearance, mix(seed_) + k);
    const double z = heap.height_on(x, y, clearance, best.z());
    if (z < best.z()) best = {x, y, z};
  }
  return best;
}

// Uniform over the circle in which the stone stays within the cylinder: r = R sqrt(u).
std::pair<double, double> Columns::in_circle(std::int64_t i, double clearance,
                                             std::uint64_t seed) const {
  const double turn = 2 * std::numbers::pi * random(seed, i, Use::x);
  const double r = std::max(0.0, clear_ - clearance) * std::sqrt(random(seed, i, Use::y));
  return {size_.x() / 2 + r * std::cos(turn), size_.y() / 2 + r * std::sin(turn)};
}

double height_of(const par::Comm& comm, const Columns& columns) {
  constexpr std::int64_t sample = 1024, placed = 1'000'000;  // columns, stones: some seconds
  const std::int64_t stones_each = std::max<std::int64_t>(1, columns.stones() / columns.count());
  const std::int64_t looked_at =
      std::min({columns.count(), sample, std::max<std::int64_t>(1, placed / stones_each)});
  const auto [begin, count] =
      io::row_range(static_cast<std::size_t>(looked_at), comm.rank(), comm.size());
  double top = 0;
  std::vector<dem::NewParticle> stones;
  for (std::size_t k = begin; k < begin + count; ++k) {
    stones.clear();
    top = std::max(
        top, columns.build(static_cast<std::int64_t>(k) * columns.count() / looked_at, stones));
  }
  return comm.max(top);
}

}  // namespace trackbed::bed
