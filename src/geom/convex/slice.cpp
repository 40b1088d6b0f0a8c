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
    (volume_of(core_below(core, normal, middle)) < wanted ? low : high) = middle;
  }
  slice(core_below(core, normal, low), parts / 2, into);
  slice(core_below(core, -normal, -low), parts - parts / 2, into);
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
