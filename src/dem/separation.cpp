#include "separation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "features.hpp"

namespace trackbed::dem {

namespace {

struct Support {
  std::size_t corner;
  double along;  // m
};

// The corner furthest along a direction; the first of several.
Support support(const Placed& core, const Vec3& direction) {
  Support best{0, -std::numeric_limits<double>::infinity()};
  for (std::size_t k = 0; k < core.corners.size(); ++k) {
    const Vec4& c = core.corners[k];
    const double along = direction.x() * c.x + direction.y() * c.y + direction.z() * c.z;
    if (along > best.along) best = {k, along};
  }
  best.along += direction.dot(core.offset);
  return best;
}

// Points of the difference second - first; the closest of their hull to the origin.
class Simplex {
 public:
  bool add(const Vec3& point) {
    for (std::size_t k = 0; k < size_; ++k)
      if (points_[k] == point) return false;
    points_[size_++] = point;
    return true;
  }
  // Closest point to the origin; corners that do not carry it are dropped. Zero if the origin lies
  // within a tetrahedron.
  Vec3 closest() {
    if (size_ == 4 && encloses()) return Vec3::Zero();
    static constexpr int faces[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
    const int count = size_ == 4 ? 4 : 1;
    Vec3 best = points_[0], weights(1, 0, 0);
    int carrier = 0;
    double least = std::numeric_limits<double>::infinity();
    for (int f = 0; f < count; ++f) {
      const auto at = [&](int k) { return points_[std::min<std::size_t>(size_ - 1, faces[f][k])]; };
      const Vec3 w = closest_weights(Vec3::Zero(), at(0), at(1), at(2));
      const Vec3 point = w[0] * at(0) + w[1] * at(1) + w[2] * at(2);
      if (point.squaredNorm() < least)
        least = point.squaredNorm(), best = point, weights = w, carrier = f;
    }
    keep(faces[carrier], weights);
    return best;
  }

 private:
  bool encloses() const {
    static constexpr int order[4][4] = {{0, 1, 2, 3}, {0, 1, 3, 2}, {0, 2, 3, 1}, {1, 2, 3, 0}};
    for (const auto& o : order) {
      const Vec3& a = points_[o[0]];
      const Vec3 n = (points_[o[1]] - a).cross(points_[o[2]] - a);
      const double inside = n.dot(points_[o[3]] - a), origin = -n.dot(a);
      if (!(inside * origin > 0)) return false;
    }
    return true;
  }
  void keep(const int (&face)[3], const Vec3& weights) {
    std::array<Vec3, 4> kept;
    std::size_t n = 0;
    for (int k = 0; k < 3; ++k)
      if (weights[k] > 0) kept[n++] = points_[std::min<std::size_t>(size_ - 1, face[k])];
    points_ = kept, size_ = n;
  }

  std::array<Vec3, 4> points_;
  std::size_t size_ = 0;
};

}  // namespace

double slab_width(const Placed& first, const Placed& second, const Vec3& normal) {
  return -support(second, -normal).along - support(first, normal).along;
}

Slab widest_slab(const Placed& first, const Placed& second, const Vec3& start, double tolerance) {
  constexpr int most_rounds = 40;  // 4 to 8 are usual
  Slab best{start, slab_width(first, second, start)};
  Simplex simplex;
  Vec3 n = start;
  for (int round = 0; round < most_rounds; ++round) {
    const Support a = support(first, n), b = support(second, -n);
    if (!simplex.add(second.corner(b.corner) - first.corner(a.corner))) break;
    const Vec3 v = simplex.closest();
    const double distance = v.norm();
    if (!(distance > 0)) break;
    n = v / distance;
    const double width = slab_width(first, second, n);
    if (width > best.width) best = {n, width};
    if (distance - best.width < tolerance) break;
  }
  return best;
}

namespace {

// Tries axes and keeps the widest slab. Across an axis on which both cores have no extent and the
// same place there is no way out: they lie in one plane, which is remembered.
struct Axes {
  const Placed &first, &second;
  Slab best{Vec3::UnitX(), -std::numeric_limits<double>::infinity()};
  Vec3 plane = Vec3::Zero();

  void look(Vec3 axis) {
    const double flat = 1e-12 * (first.radius + second.radius);  // rounding
    const double length = axis.norm();
    if (!(length > 1e-300)) return;
    axis /= length;
    const double ahead = slab_width(first, second, axis), behind = slab_width(first, second, -axis);
    if (std::max(std::abs(ahead), std::abs(behind)) < flat) {
      plane = axis;
      return;
    }
    if (ahead > best.width) best = {axis, ahead};
    if (behind > best.width) best = {-axis, behind};
  }
  void look_along_plane() {
    for (const Placed* p : {&first, &second})
      for (const Core::Edge& e : p->core->edges)
        look(plane.cross(p->corner(e[1]) - p->corner(e[0])));
  }
};

}  // namespace

Slab separating_axis(const Placed& first, const Placed& second) {
  Axes axes{first, second};
  for (const Placed* p : {&first, &second})
    for (const Core::Triangle& t : p->core->triangles) {
      const Vec3 a = p->corner(t[0]);
      axes.look((p->corner(t[1]) - a).cross(p->corner(t[2]) - a));
    }
  for (const Core::Edge& e : first.core->edges) {
    const Vec3 u = first.corner(e[1]) - first.corner(e[0]);
    for (const Core::Edge& g : second.core->edges)
      axes.look(u.cross(second.corner(g[1]) - second.corner(g[0])));
  }
  if (!axes.plane.isZero()) axes.look_along_plane();
  if (!std::isfinite(axes.best.width)) axes.best.width = 0;  // points and segments have no inside
  return axes.best;
}

}  // namespace trackbed::dem
