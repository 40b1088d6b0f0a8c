// Reading and interpolation of the base motion.
#include "base_motion.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "trackbed/core/error.hpp"
#include "trackbed/input/table.hpp"

namespace trackbed::fem {

namespace {

// Of the largest speed. Wavelets that are computed fade in digits of rounding instead of 0, and
// nobody wants to edit a table for that; the ground does not show a jump of so little.
constexpr double at_rest = 1e-9;

}  // namespace

// A wave that begins or ends in motion would kick the ground: refused instead of faded.
BaseMotion::BaseMotion(const std::string& path) {
  std::vector<int> lines;
  const auto columns = input::read_table(path, {"time_s", "vx_m_s", "vz_m_s"}, "time_s", &lines);
  times_ = columns[0];
  if (times_.size() < 2) throw InputError({fmt::format("{}: needs at least two rows", path)});
  for (std::size_t r = 0; r < times_.size(); ++r)
    rows_.emplace_back(columns[1][r], 0, columns[2][r]);
  require_rest(path, lines);
}

// At both ends what counts as rest becomes rest to the bit, all rows of it: what is left would go
// on in `at`, and move where the wave begins and ends.
void BaseMotion::require_rest(const std::string& path, const std::vector<int>& lines) {
  const double largest = fastest();
  const auto moves = [&](const Vec3& row) { return row.norm() > at_rest * largest; };
  const auto first = std::find_if(rows_.begin(), rows_.end(), moves);
  const auto last = std::find_if(rows_.rbegin(), rows_.rend(), moves).base();
  for (const std::size_t r : {std::size_t{0}, rows_.size() - 1}) {
    if (!moves(rows_[r])) continue;
    const Vec3& v = rows_[r];
    throw InputError({fmt::format(
        "{}:{}: vx_m_s = {:g}, vz_m_s = {:g}: must begin and end at rest: the {} row may move with "
        "{:g} of the largest speed ({:g} m/s) at most",
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

// Local and without state: any time may be asked in any order.
Vec3 BaseMotion::at(double time) const {
  if (time <= times_.front()) return rows_.front();
  if (time >= times_.back()) return rows_.back();
  const auto hi = static_cast<std::size_t>(std::upper_bound(times_.begin(), times_.end(), time) -
                                           times_.begin());
  const double share = (time - times_[hi - 1]) / (times_[hi] - times_[hi - 1]);
  return rows_[hi - 1] + share * (rows_[hi] - rows_[hi - 1]);
}

}  // namespace trackbed::fem
