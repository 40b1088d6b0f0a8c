// From the triangles of a hull to its faces.
//
// Scans and computed points have corners that are off the plane of their face by rounding errors,
// so faces are gathered with a tolerance: starting from the largest triangle, all that stay within
// it. A corner of less than three faces is within an edge or a face and is left out.
//
// Cost: O(n log n) for the hull, then a pass over its triangles per face. Merging triangles pair by
// pair while their normals are close would drift along a gently curved surface; here all of a face
// stays within one tolerance of one plane.
#include "geom/convex/hull.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>

namespace trackbed::geom {

namespace {

using Points = std::vector<Vec3>;
using Loop = std::vector<int>;
using DirectedEdge = std::array<int, 2>;  // from corner to corner, with the triangle on its left

struct Plane {
  Vec3 normal;  // unit
  double offset;
  double height(const Vec3& p) const { return normal.dot(p) - offset; }
};

const Vec3& at(const Points& points, int k) { return points[static_cast<std::size_t>(k)]; }

// Twice the area times the outward normal, m^2.
Vec3 area_of(const Points& points, const Triangle& t) {
  return (at(points, t[1]) - at(points, t[0])).cross(at(points, t[2]) - at(points, t[0]));
}

// The first of equals, so that the hull depends on the order of points only.
std::size_t furthest(const Points& points, const auto& distance) {
  std::size_t best = 0;
  for (std::size_t k = 1; k < points.size(); ++k)
    if (distance(points[k]) > distance(points[best])) best = k;
  return best;
}

// Number of the face each triangle belongs to.
class Faces {
 public:
  // The largest triangle first: its plane is the most accurate, and slivers, whose normals are
  // noise, are joined to it instead of starting faces of their own. Stable, so that equal areas
  // keep the order of CGAL.
  Faces(const Points& points, const std::vector<Triangle>& triangles, double tolerance)
      : points_(points), triangles_(triangles), tolerance_(tolerance), face_(triangles.size(), -1) {
    for (std::size_t t = 0; t < triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) left_[{triangles[t][k], triangles[t][(k + 1) % 3]}] = t;
    std::vector<std::size_t> order(triangles.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return area_of(points, triangles[a]).norm() > area_of(points, triangles[b]).norm();
    });
    for (const std::size_t t : order)
      if (face_[t] < 0) grow(t);
  }

  // The loop around each face, without corners of less than three faces. Each directed edge between
  // two faces is on the border of the face on its left; the directed edges of one face, joined head
  // to tail, are its loop, counter-clockwise seen from outside. A face that is left with two
  // corners was narrower than the tolerance and is dropped: its neighbours become adjacent.
  std::vector<Loop> loops() const {
    std::map<int, std::set<int>> around;
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      for (const int v : triangles_[t]) around[v].insert(face_[t]);
    // Every directed edge has its opposite, since the hull is closed: `at` does not throw.
    std::vector<std::map<int, int>> next(static_cast<std::size_t>(count_));
    for (const auto& [edge, t] : left_)
      if (face_[left_.at({edge[1], edge[0]})] != face_[t])
        next[static_cast<std::size_t>(face_[t])][edge[0]] = edge[1];
    std::vector<Loop> loops;
    for (const auto& following : next) {
      Loop loop;
      int v = following.begin()->first;
      for (std::size_t k = 0; k < following.size(); ++k, v = following.at(v))
        if (around.at(v).size() > 2) loop.push_back(v);
      if (loop.size() > 2) loops.push_back(loop);
    }
    return loops;
  }

 private:
  // Over edges shared with the face up to now; the plane is that of the seed and is not updated. A
  // distant triangle that happens to be in the same plane is therefore not included.
  void grow(std::size_t seed) {
    const Vec3 normal = area_of(points_, triangles_[seed]).normalized();
    const Plane plane{normal, normal.dot(at(points_, triangles_[seed][0]))};
    std::vector<std::size_t> front{seed};
    face_[seed] = count_;
    while (!front.empty()) {
      const Triangle triangle = triangles_[front.back()];
      front.pop_back();
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t other = left_.at({triangle[(k + 1) % 3], triangle[k]});
        if (face_[other] >= 0 || !within(plane, triangles_[other])) continue;
        face_[other] = count_;
        front.push_back(other);
      }
    }
    ++count_;
  }

  bool within(const Plane& plane, const Triangle& triangle) const {
    return std::all_of(triangle.begin(), triangle.end(),
                       [&](int v) { return std::abs(plane.height(at(points_, v))) <= tolerance_; });
  }

  const Points& points_;
  const std::vector<Triangle>& triangles_;
  double tolerance_;
  std::vector<int> face_;
  int count_ = 0;
  std::map<DirectedEdge, std::size_t> left_;
};

// Only the corners used by loops, in the order given: `number` is sorted by old index, which keeps
// the order.
Convex with_corners_of(const Points& points, std::vector<Loop> loops, double slack) {
  std::map<int, int> number;
  for (const Loop& loop : loops)
    for (const int v : loop) number[v] = 0;
  Points corners;
  for (auto& [old, fresh] : number) {
    fresh = static_cast<int>(corners.size());
    corners.push_back(at(points, old));
  }
  for (Loop& loop : loops)
    for (int& v : loop) v = number.at(v);
  return assemble(std::move(corners), loops, slack);
}

// Points within the tolerance of a plane: a polygon with two faces. Projected to axes u, v with u x
// v = normal, so that counter-clockwise in the plane is counter-clockwise seen from the tip of the
// normal. The plane hull returns its input coordinates unchanged, by which the points are
// identified.
Convex flat_hull(const Points& points, const Vec3& normal, double slack) {
  const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
  std::vector<Eigen::Vector2d> flat;
  std::map<std::array<double, 2>, int> number;
  for (const Vec3& p : points) {
    number.insert({{u.dot(p), v.dot(p)}, static_cast<int>(flat.size())});
    flat.emplace_back(u.dot(p), v.dot(p));
  }
  Loop front;
  for (const auto& p : convex_hull(flat)) front.push_back(number.at({p.x(), p.y()}));
  return with_corners_of(points, {front, Loop(front.rbegin(), front.rend())}, slack);
}

}  // namespace

// The dimension is determined first: the furthest points span a segment, the point furthest from
// its line a triangle, the one furthest from its plane a body. Extents within the tolerance count
// as zero, so that CGAL is called only for a body of non-zero volume.
Convex convex_hull(const Points& points, double merge) {
  if (points.empty()) throw std::invalid_argument("a hull requires at least one point");
  for (const Vec3& p : points)
    if (!p.allFinite()) throw std::invalid_argument("a point is not finite");
  const double tolerance = merge * extent_of(points);
  const double slack = std::max(1e-6, 10 * merge);  // a face may be bent by the tolerance
  const Vec3 a = points[furthest(points, [&](const Vec3& p) { return (p - points[0]).norm(); })];
  const Vec3 b = points[furthest(points, [&](const Vec3& p) { return (p - a).norm(); })];
  if ((b - a).norm() <= tolerance) return {{points[0]}, {}, {}};
  const Vec3 along = (b - a).normalized();
  const auto aside = [&](const Vec3& p) { return along.cross(p - a).norm(); };
  const Vec3 c = points[furthest(points, aside)];
  if (aside(c) <= tolerance) return assemble({a, b}, {}, slack);
  const Vec3 normal = along.cross(c - a).normalized();
  const auto above = [&](const Vec3& p) { return std::abs(normal.dot(p - a)); };
  if (above(points[furthest(points, above)]) <= tolerance) return flat_hull(points, normal, slack);
  const auto triangles = hull_triangles(points);
  return with_corners_of(points, Faces(points, triangles, tolerance).loops(), slack);
}

}  // namespace trackbed::geom
