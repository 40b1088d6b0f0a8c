// Reading and interpolation of the base motion.
#include "fem/time/base_motion.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "trackbed/core/error.hpp"
#include "trackbed/input/table.hpp"

namespace trackbed::fem {

namespace {

// Relative to the largest speed. Computed wavelets decay to rounding errors instead of 0, and users
// should not have to edit the table; a jump of this size has no visible effect on the ground.
constexpr double at_rest = 1e-9;

}  // namespace

// A wave that begins or ends in motion would excite the ground by a jump: it is refused, not
// tapered.
BaseMotion::BaseMotion(const std::string& path) {
  std::vector<int> lines;
  const auto columns = input::read_table(path, {"time_s", "vx_m_s", "vz_m_s"}, "time_s", &lines);
  times_ = columns[0];
  if (times_.size() < 2) throw InputError({fmt::format("{}: needs at least two rows", path)});
  for (std::size_t r = 0; r < times_.size(); ++r)
    rows_.emplace_back(columns[1][r], 0, columns[2][r]);
  require_zero_ends(path, lines);
}

// Rows at both ends that count as zero are set to exactly zero: the remainder would continue in
// `at`, and shift the begin and end of the wave.
void BaseMotion::require_zero_ends(const std::string& path, const std::vector<int>& lines) {
  const double largest = fastest();
  const auto moves = [&](const Vec3& row) { return row.norm() > at_rest * largest; };
  const auto first = std::find_if(rows_.begin(), rows_.end(), moves);
  const auto last = std::find_if(rows_.rbegin(), rows_.rend(), moves).base();
  for (const std::size_t r : {std::size_t{0}, rows_.size() - 1}) {
    if (!moves(rows_[r])) continue;
    const Vec3& v = rows_[r];
    throw InputError(
        {fmt::format("{}:{}: vx_m_s = {:g}, vz_m_s = {:g}: the wave must begin and end at rest: "
                     "the speed in the {} row must be at most {:g} of the largest speed ({:g} m/s)",
                     path, lines[r], v.x(), v.z(), r == 0 ? "first" : "last", at_rest, largest)});
  }
  const auto stop = [](Vec3& row) { row.setZero(); };
  std::for_each(rows_.begin(), first, stop);
  std::for_each(std::max(first, last), rows_.end(), stop);
}

double BaseMotion::fastest() const {
  double largest = 0;
  for (const Vec3& row : rows_) largest = std::max(largest, row.norm());
  return largest;
}

double BaseMotion::begin() const {
  std::size_t r = 0;
  while (r + 1 < rows_.size() && rows_[r + 1].isZero(0)) ++r;
  return times_[r];
}

double BaseMotion::end() const {
  std::size_t r = rows_.size() - 1;
  while (r > 0 && rows_[r - 1].isZero(0)) --r;
  return r > 0 ? times_[r] : times_.back();
}

bool BaseMotion::moves(int axis) const {
  return std::any_of(rows_.begin(), rows_.end(), [&](const Vec3& row) { return row[axis] != 0; });
}

// Local and without state: times may come in any order.
Vec3 BaseMotion::at(double time) const {
  if (time <= times_.front()) return rows_.front();
  if (time >= times_.back()) return rows_.back();
  const auto hi = static_cast<std::size_t>(std::upper_bound(times_.begin(), times_.end(), time) -
                                           times_.begin());
  const double fraction = (time - times_[hi - 1]) / (times_[hi] - times_[hi - 1]);
  return rows_[hi - 1] + fraction * (rows_[hi] - rows_[hi - 1]);
}

}  // namespace trackbed::fem
