// Callipers: thickness, width and length of a stone, and its greatest extent.
//
// The smallest distance of two parallel planes that touch a convex polyhedron is reached across a
// face and a corner or across two edges (Houle, Toussaint 1988, doi:10.1109/34.6790), and the
// smallest one at right angles to it flush with the projection of an edge. So both are found by
// trying faces and edges, to rounding errors; a ball that sweeps the hull adds its diameter and
// changes neither direction. Only pairs of edges whose common normal is outward at both are tried,
// which follows from the adjacent faces: cost edges^2 tests and few evaluations, 0.1 ms for 24
// corners.
//
// Spheres of different radii have no such finite list; a raster of directions and a search with
// halving steps are used instead, as for holes (openings.cpp).
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "trackbed/geom/stone.hpp"

namespace trackbed::geom {

namespace {

using std::numbers::pi;
constexpr double infinite = std::numeric_limits<double>::infinity();

struct Width {
  double value = infinite;
  Vec3 direction = Vec3::UnitZ();
};

double extent_along(const std::vector<Vec3>& points, const Vec3& direction) {
  double low = infinite, high = -infinite;
  for (const Vec3& p : points) {
    const double along = direction.dot(p);
    low = std::min(low, along), high = std::max(high, along);
  }
  return high - low;
}

// The extent along any direction bounds the smallest width from above: an additional candidate
// costs time but no accuracy. Parallel edges have no common normal.
template <class Extent>
void try_direction(const Extent& extent, const Vec3& direction, Width& best) {
  const double length = direction.norm();
  if (!(length > 0)) return;
  const Vec3 unit = direction / length;
  if (const double value = extent(unit); value < best.value) best = {value, unit};
}

// An edge and the directions from it into its two faces.
struct Ridge {
  Vec3 at, along;
  std::array<Vec3, 2> inward;
  // Whether a plane with this outward normal that contains the edge touches the core there.
  bool touches(const Vec3& normal) const {
    constexpr double flush = 1e-12;  // faces in the plane count
    const double limit = flush * normal.norm() * along.norm();
    return normal.dot(inward[0]) <= limit && normal.dot(inward[1]) <= limit;
  }
};

// Direction into the face: to any of its corners that is not on the edge.
Vec3 into(const Convex& core, const Face& face, const Edge& edge) {
  for (const int v : face.vertices)
    if (v != edge.vertices[0] && v != edge.vertices[1])
      return core.vertices[static_cast<std::size_t>(v)] -
             core.vertices[static_cast<std::size_t>(edge.vertices[0])];
  return Vec3::Zero();
}

std::vector<Ridge> ridges_of(const Convex& core) {
  std::vector<Ridge> ridges;
  for (const Edge& edge : core.edges) {
    const Vec3& from = core.vertices[static_cast<std::size_t>(edge.vertices[0])];
    Ridge ridge{from, core.vertices[static_cast<std::size_t>(edge.vertices[1])] - from, {}};
    for (const int side : {0, 1}) {
      const auto f = static_cast<std::size_t>(edge.faces[static_cast<std::size_t>(side)]);
      ridge.inward[static_cast<std::size_t>(side)] = into(core, core.faces[f], edge);
    }
    ridges.push_back(ridge);
  }
  return ridges;
}

// Of a core with faces.
Width thickness_of(const Convex& core) {
  const auto extent = [&](const Vec3& direction) { return extent_along(core.vertices, direction); };
  Width best;
  for (const Face& face : core.faces) try_direction(extent, face.normal, best);
  const std::vector<Ridge> ridges = ridges_of(core);
  for (std::size_t i = 0; i < ridges.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      Vec3 normal = ridges[i].along.cross(ridges[j].along);
      if (normal.dot(ridges[i].at - ridges[j].at) < 0) normal = -normal;
      if (ridges[i].touches(normal) && ridges[j].touches(-normal))
        try_direction(extent, normal, best);
    }
  return best;
}

// At right angles to `across`, flush with the projection of an edge.
Width width_of(const Convex& core, const Vec3& across) {
  const auto extent = [&](const Vec3& direction) { return extent_along(core.vertices, direction); };
  Width best;
  for (const Edge& edge : core.edges)
    try_direction(extent,
                  across.cross(core.vertices[static_cast<std::size_t>(edge.vertices[1])] -
                               core.vertices[static_cast<std::size_t>(edge.vertices[0])]),
                  best);
  return best;
}

Callipers box_along(const Vec3& s, const Vec3& i, double thickness, double width, double length) {
  Callipers box{length, width, thickness, Mat3::Identity()};
  box.axes << i.cross(s), i, s;
  return box;
}

std::vector<Sphere> corners_of(const std::vector<Piece>& pieces) {
  std::vector<Sphere> corners;
  for (const Piece& piece : pieces)
    for (const Vec3& corner : piece.core.vertices) corners.push_back({corner, piece.radius});
  return corners;
}

double extent_along(const std::vector<Sphere>& spheres, const Vec3& direction) {
  double low = infinite, high = -infinite;
  for (const Sphere& s : spheres) {
    const double along = direction.dot(s.centre);
    low = std::min(low, along - s.radius), high = std::max(high, along + s.radius);
  }
  return high - low;
}

// Rotates about `axes` by a step that is halved when no rotation improves the result.
Width refined(const std::vector<Sphere>& spheres, Width best, const std::vector<Vec3>& axes) {
  constexpr double start = 0.04, end = 1e-8;  // radians, half the raster's spacing to rounding
  // A smaller gain does not count: widths that are equal for many attitudes, as those of a ball,
  // would otherwise decrease by rounding errors for ever.
  constexpr double gain = 1e-10;
  const auto extent = [&](const Vec3& direction) { return extent_along(spheres, direction); };
  for (double step = start; step > end;) {
    Width next = best;
    for (const Vec3& axis : axes)
      for (const double turn : {-step, step})
        try_direction(extent, Eigen::AngleAxisd(turn, axis) * best.direction, next);
    if (next.value < (1 - gain) * best.value)
      best = next;
    else
      step /= 2;
  }
  return best;
}

// The best direction of the raster need not belong to the best minimum: several are refined.
Width best_of(const std::vector<Sphere>& spheres, const std::vector<Vec3>& raster,
              const std::vector<Vec3>& axes) {
  constexpr std::size_t kept = 12;
  std::vector<Width> widths;
  for (const Vec3& direction : raster)
    widths.push_back({extent_along(spheres, direction), direction});
  std::partial_sort(widths.begin(), widths.begin() + kept, widths.end(),
                    [](const Width& a, const Width& b) { return a.value < b.value; });
  Width best;
  for (std::size_t k = 0; k < kept; ++k) {
    const Width found = refined(spheres, widths[k], axes);
    if (found.value < best.value) best = found;
  }
  return best;
}

Callipers searched(const std::vector<Sphere>& spheres) {
  constexpr int directions = 1000, turns = 360;  // 4.5 and half a degree apart
  std::vector<Vec3> raster, ring, axes;
  for (int k = 0; k < directions; ++k) {  // Fibonacci lattice on half a sphere
    const double z = (k + 0.5) / directions, r = std::sqrt(1 - z * z);
    const double turn = 2 * pi * k / std::numbers::phi;
    raster.emplace_back(r * std::cos(turn), r * std::sin(turn), z);
  }
  for (int k = 0; k < 27; ++k)
    if (const Vec3 about(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1); !about.isZero())
      axes.push_back(about.normalized());
  const Width s = best_of(spheres, raster, axes);
  const Vec3 u = s.direction.unitOrthogonal(), v = s.direction.cross(u);
  for (int k = 0; k < turns; ++k)
    ring.push_back(std::cos(pi * k / turns) * u + std::sin(pi * k / turns) * v);
  const Width i = best_of(spheres, ring, {s.direction});
  return box_along(s.direction, i.direction, s.value, i.value,
                   extent_along(spheres, i.direction.cross(s.direction)));
}

}  // namespace

Callipers callipers_of(const Convex& core) {
  if (core.faces.empty()) {  // a point or a segment
    Callipers box;
    const Vec3 span = core.vertices.back() - core.vertices.front();
    box.length = span.norm();
    const Vec3 along = box.length > 0 ? Vec3(span / box.length) : Vec3::UnitX();
    const Vec3 aside = along.unitOrthogonal();
    box.axes << along, aside, along.cross(aside);
    return box;
  }
  const Width s = thickness_of(core);
  const Width i = width_of(core, s.direction);
  return box_along(s.direction, i.direction, s.value, i.value,
                   extent_along(core.vertices, i.direction.cross(s.direction)));
}

Callipers callipers_of(const std::vector<Piece>& pieces) {
  std::vector<Vec3> points;
  bool alike = true;
  for (const Piece& piece : pieces) {
    alike = alike && piece.radius == pieces.front().radius;
    points.insert(points.end(), piece.core.vertices.begin(), piece.core.vertices.end());
  }
  if (!alike) return searched(corners_of(pieces));
  Callipers box = callipers_of(convex_hull(points));
  for (double* side : {&box.length, &box.width, &box.thickness}) *side += 2 * pieces[0].radius;
  return box;
}

double greatest_extent(const std::vector<Piece>& pieces) {
  const std::vector<Sphere> corners = corners_of(pieces);
  double greatest = 0;
  for (const Sphere& a : corners)
    for (const Sphere& b : corners)
      greatest = std::max(greatest, (a.centre - b.centre).norm() + a.radius + b.radius);
  return greatest;
}

}  // namespace trackbed::geom
