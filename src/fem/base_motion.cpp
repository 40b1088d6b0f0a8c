// Reading and interpolation of the base motion.
#include "base_motion.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "trackbed/core/error.hpp"
#include "trackbed/input/table.hpp"

namespace trackbed::fem {

// A wave that begins or ends in motion would kick the ground: refused instead of faded.
BaseMotion::BaseMotion(const std::string& path) {
  const auto columns = input::read_table(path, {"time_s", "vx_m_s", "vz_m_s"}, "time_s");
  times_ = columns[0];
  if (times_.size() < 2) throw InputError({fmt::format("{}: needs at least two rows", path)});
  for (std::size_t r = 0; r < times_.size(); ++r) {
    Motion row{Vec3(columns[1][r], 0, columns[2][r]), Vec3::Zero()};
    if (r > 0)
      row.displacement = rows_[r - 1].displacement +
                         0.5 * (times_[r] - times_[r - 1]) * (rows_[r - 1].velocity + row.velocity);
    rows_.push_back(row);
  }
  if (!rows_.front().velocity.isZero(0) || !rows_.back().velocity.isZero(0))
    throw InputError(
        {fmt::format("{}: must begin and end at rest: the first and the last row need vx_m_s = "
                     "vz_m_s = 0",
                     path)});
  const Vec3 let_go = at(0).displacement;
  for (Motion& row : rows_) row.displacement -= let_go;
}

double BaseMotion::begin() const {
  std::size_t r = 0;
  while (r + 1 < rows_.size() && rows_[r + 1].velocity.isZero(0)) ++r;
  return times_[r];
}

double BaseMotion::end() const {
  std::size_t r = rows_.size() - 1;
  while (r > 0 && rows_[r - 1].velocity.isZero(0)) --r;
  return r > 0 ? times_[r] : times_.back();
}

bool BaseMotion::moves(int axis) const {
  return std::any_of(rows_.begin(), rows_.end(),
                     [&](const Motion& row) { return row.velocity[axis] != 0; });
}

// Local and without state: any time may be asked in any order.
BaseMotion::Motion BaseMotion::at(double time) const {
  if (time <= times_.front()) return rows_.front();
  if (time >= times_.back()) return rows_.back();
  const auto hi = static_cast<std::size_t>(std::upper_bound(times_.begin(), times_.end(), time) -
                                           times_.begin());
  const Motion &before = rows_[hi - 1], &after = rows_[hi];
  const double since = time - times_[hi - 1], share = since / (times_[hi] - times_[hi - 1]);
  const Vec3 velocity = before.velocity + share * (after.velocity - before.velocity);
  return {velocity, before.displacement + 0.5 * since * (before.velocity + velocity)};
}

}  // namespace trackbed::fem
