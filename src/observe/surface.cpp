// The height of the bed over a lattice of cells, as measured from above by levelling or laser
// scanning.
//
// Cost, at the end of a stage: a sort of the stones by height, and the points of those that are not
// entirely below higher stones in all cells beneath them: a layer of stones, not the whole bed.
// Rejected: rays against hulls, exact but with a search per ray; the points within a stone are an
// eighth of its size apart, its corners are exact.
#include <algorithm>
#include <cmath>
#include <limits>

#include "observe/impl.hpp"

namespace trackbed::observe {

namespace {

// Cells of equal size between the sides; a plane model has one row.
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
  // The cell of a point. A point beyond a periodic side belongs to the cell of its image, a point
  // beyond another side to none.
  std::size_t cell(const Vec3& point, const dem::Domain& domain) const {
    return cell(place(point, 0, domain), place(point, 1, domain), domain);
  }
  std::size_t cell(double along, double across, const dem::Domain& domain) const {
    const std::array<double, 2> place{along, across};
    std::array<std::size_t, 2> at{0, 0};
    for (std::size_t k = 0; k < 2; ++k) {
      const auto n = static_cast<double>(count[k]);
      const double inside = domain.periodic[k] ? place[k] - n * std::floor(place[k] / n) : place[k];
      if (!(inside >= 0 && inside < n)) return cells();
      at[k] = static_cast<std::size_t>(inside);
    }
    return at[1] * count[0] + at[0];
  }
  // In cells from the low side, without periodic mapping.
  double place(const Vec3& point, int axis, const dem::Domain& domain) const {
    if (axis == 1 && domain.dimension == Dimension::plane) return 0;
    return std::floor((point[axis] - low[axis]) / size[static_cast<std::size_t>(axis)]);
  }
  // Whether `holds` is true for all cells below a sphere.
  template <class Holds>
  bool all_below(const Vec3& centre, double radius, const dem::Domain& domain,
                 Holds&& holds) const {
    const Vec3 first = centre.array() - radius, last = centre.array() + radius;
    for (double across = place(first, 1, domain); across <= place(last, 1, domain); ++across)
      for (double along = place(first, 0, domain); along <= place(last, 0, domain); ++along) {
        const std::size_t at = cell(along, across, domain);
        if (at < cells() && !holds(at)) return false;
      }
    return true;
  }
  std::size_t cells() const { return count[0] * count[1]; }
};

// Particles in descending order of their highest points.
std::vector<std::size_t> by_height(const dem::Particles& particles) {
  std::vector<std::pair<double, std::size_t>> tops;
  for (std::size_t i = 0; i < particles.size(); ++i)
    tops.emplace_back(-(particles[i].position.z() + particles[i].radius), i);
  std::sort(tops.begin(), tops.end());
  std::vector<std::size_t> order;
  for (const auto& [top, i] : tops) order.push_back(i);
  return order;
}

}  // namespace

// The maximum over ranks is that of all stones, independent of their distribution and order.
std::vector<double> surface_of(const par::Comm& comm, const dem::Particles& particles,
                               double cell) {
  const dem::Domain& domain = particles.domain();
  const Lattice lattice(domain, cell);
  std::vector<double> top(lattice.cells(), -std::numeric_limits<double>::infinity());
  const auto update = [&](const Vec3& point) {
    const std::size_t at = lattice.cell(point, domain);
    if (at < top.size()) top[at] = std::max(top[at], point.z());
  };
  for (const std::size_t i : by_height(particles)) {
    const dem::ParticleView stone = particles[i];
    const double highest = stone.position.z() + stone.radius;
    const auto is_covered = [&](std::size_t at) { return top[at] >= highest; };
    if (lattice.all_below(stone.position, stone.radius, domain, is_covered)) continue;
    particles.points(i, update);
    particles.corners(i, [&](const Vec3& centre, double r) { update(centre + Vec3(0, 0, r)); });
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
