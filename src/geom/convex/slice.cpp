// Convex cores cut into convex parts of equal volume.
//
// Rounded with one radius, the parts of a cut core overlap and fill exactly the volume of the
// whole: the sweep of a union is the union of the sweeps. So a stone may be made of several pieces
// that together equal a single one, to test the treatment of several pieces.
#include <algorithm>
#include <stdexcept>

#include "trackbed/geom/stone.hpp"

namespace trackbed::geom {

namespace {

// The part of a core with normal . x <= offset: hull of the corners below and of the points where
// edges cross the plane. Exact for a convex core, and no face has to be clipped.
Convex below(const Convex& core, const Vec3& normal, double offset) {
  std::vector<Vec3> points;
  for (const Vec3& v : core.vertices)
    if (normal.dot(v) <= offset) points.push_back(v);
  for (const Edge& edge : core.edges) {
    const Vec3 &a = core.vertices[static_cast<std::size_t>(edge.vertices[0])],
               &b = core.vertices[static_cast<std::size_t>(edge.vertices[1])];
    const double ha = normal.dot(a) - offset, hb = normal.dot(b) - offset;
    if ((ha < 0 && hb > 0) || (ha > 0 && hb < 0)) points.push_back(a + ha / (ha - hb) * (b - a));
  }
  return convex_hull(points);
}

double volume_of(const Convex& core) { return steiner_of(core).volume; }

// Bisects by volume recursively; for odd numbers the fractions are (n/2)/n. Always across the
// longest axis, that of the smallest moment, so that parts stay compact.
void slice(const Convex& core, int parts, std::vector<Convex>& into) {
  if (parts == 1) {
    into.push_back(core);
    return;
  }
  const Solid solid = piece_solid({core, 0});
  Eigen::Index longest = 0;
  solid.gyration.minCoeff(&longest);
  const Vec3 normal = solid.axes.toRotationMatrix().col(longest);
  double low = normal.dot(core.vertices[0]), high = low;
  for (const Vec3& v : core.vertices)
    low = std::min(low, normal.dot(v)), high = std::max(high, normal.dot(v));
  const double wanted = solid.volume * (parts / 2) / parts;
  // To 1e-12 of the extent.
  constexpr int halvings = 40;
  const double margin = 1e-6 * (high - low);  // no slivers
  low += margin, high -= margin;
  for (int k = 0; k < halvings; ++k) {
    const double middle = (low + high) / 2;
    (volume_of(below(core, normal, middle)) < wanted ? low : high) = middle;
  }
  slice(below(core, normal, low), parts / 2, into);
  slice(below(core, -normal, -low), parts - parts / 2, into);
}

}  // namespace

std::vector<Convex> sliced(const Convex& core, int parts) {
  if (parts < 1) throw std::invalid_argument("the number of parts must be at least 1");
  if (parts > 1 && !(volume_of(core) > 0))
    throw std::invalid_argument("a core without volume cannot be cut into parts");
  std::vector<Convex> all;
  slice(core, parts, all);
  return all;
}

}  // namespace trackbed::geom
