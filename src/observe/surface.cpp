// The height of the bed over a lattice of cells: what a level or a laser sees from above.
//
// Cost: the points of every stone once, at the end of a stage. Rejected: rays against hulls, exact
// but a search per ray; the points within a stone lie an eighth of its size apart, its corners at
// its very ends.
#include <algorithm>
#include <cmath>
#include <limits>

#include "observe/room.hpp"

namespace trackbed::observe {

namespace {

// Cells of about equal size from side to side; a plane model has one row.
struct Lattice {
  Vec3 low = Vec3::Zero();
  std::array<std::size_t, 2> count{1, 1};
  std::array<double, 2> size{1, 1};  // m

  Lattice(const dem::Domain& domain, double cell) : low(domain.low) {
    for (const int axis : {0, 1}) {
      const double length = domain.high[axis] - domain.low[axis];
      const auto k = static_cast<std::size_t>(axis);
      if (axis == 0 || domain.dimension == Dimension::space)
        count[k] = static_cast<std::size_t>(std::max(1.0, std::round(length / cell)));
      size[k] = length / static_cast<double>(count[k]);
    }
  }
  // Of a point; those that stick out over a side belong to the cell they come in again, if that
  // side is periodic, else to none.
  std::size_t cell(const Vec3& point, const dem::Domain& domain) const {
    std::array<std::size_t, 2> at{0, 0};
    for (const int axis : {0, 1}) {
      const auto k = static_cast<std::size_t>(axis);
      if (count[k] == 1 && domain.dimension == Dimension::plane && axis == 1) continue;
      const auto n = static_cast<double>(count[k]);
      double place = std::floor((point[axis] - low[axis]) / size[k]);
      if (domain.periodic[k]) place -= n * std::floor(place / n);
      if (!(place >= 0 && place < n)) return cells();
      at[k] = static_cast<std::size_t>(place);
    }
    return at[1] * count[0] + at[0];
  }
  std::size_t cells() const { return count[0] * count[1]; }
};

}  // namespace

// The maximum over ranks is that of all stones, whatever their number.
std::vector<double> surface_of(const par::Comm& comm, const dem::Particles& particles,
                               double cell) {
  const dem::Domain& domain = particles.domain();
  const Lattice lattice(domain, cell);
  std::vector<double> top(lattice.cells(), -std::numeric_limits<double>::infinity());
  const auto see = [&](const Vec3& point) {
    const std::size_t at = lattice.cell(point, domain);
    if (at < top.size()) top[at] = std::max(top[at], point.z());
  };
  for (std::size_t i = 0; i < particles.size(); ++i) {
    particles.points(i, see);
    particles.corners(i, [&](const Vec3& centre, double r) { see(centre + Vec3(0, 0, r)); });
  }
  comm.max(std::span(top));
  std::vector<double> rows;
  for (std::size_t k = 0; k < top.size(); ++k) {
    const double x =
        lattice.low.x() + (static_cast<double>(k % lattice.count[0]) + 0.5) * lattice.size[0];
    const double y =
        lattice.low.y() + (static_cast<double>(k / lattice.count[0]) + 0.5) * lattice.size[1];
    const double z = std::isfinite(top[k]) ? top[k] : std::numeric_limits<double>::quiet_NaN();
    rows.insert(rows.end(), {x, y, z});
  }
  return rows;
}

}  // namespace trackbed::observe
