// The distance is bounded from both sides: GJK's simplex gives a distance that is too large, each
// direction the width of a slab that is too small or exact, so the error is known. Cores that
// overlap have no closest points; there the widest (least negative) slab is searched over all
// possible axes.
//
// Rejected for overlapping cores: EPA (expanding polytope), which gives the shortest direction
// only, while the blend of deep.hpp needs all directions that are nearly as short.
#include "dem/shape/separation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "dem/shape/features.hpp"

namespace trackbed::dem {

namespace {

struct Support {
  std::size_t corner;
  double along;  // m
};

// The corner furthest along a direction; the first of several, so that the choice does not change
// with rounding from rank to rank. All corners are examined: climbing along edges would need the
// neighbours of each and pays only for many corners.
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

// Points of the difference second - first, and the point of their hull closest to the origin. Up to
// four points; fewer are treated as a triangle with repeated points (`closest_weights`).
class Simplex {
 public:
  // False if the point is already contained: the search has returned to a previous state and ends.
  bool add(const Vec3& point) {
    for (std::size_t k = 0; k < size_; ++k)
      if (points_[k] == point) return false;
    points_[size_++] = point;
    return true;
  }
  // Closest point to the origin; corners of zero weight are dropped. Zero if the origin is within a
  // tetrahedron.
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
  // For each face the origin is on the side of the fourth corner. A tetrahedron without volume
  // encloses nothing.
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

// The best slab is kept, since widths need not grow from iteration to iteration.
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
    // The cores touch or overlap: there is no direction left to follow.
    if (!(distance > 0)) break;
    n = v / distance;
    const double width = slab_width(first, second, n);
    if (width > best.width) best = {n, width};
    // The true distance is between the two.
    if (distance - best.width < tolerance) break;
  }
  return best;
}

namespace {

// The origin of an axis determines its rotation: with the body of its face or with both edges.
enum class Source { face_of_first, face_of_second, edges };
struct Axis {
  Source source;
  Vec3 along;  // edges: u x v
  Vec3 u = Vec3::Zero(), v = Vec3::Zero();
};

// Enumerates all axes, in both directions. Across an axis on which both cores have no extent and
// the same position they cannot be separated: they are in one plane, and directions within it are
// tried as well. Separating axis theorem (Gottschalk, Lin, Manocha 1996,
// doi:10.1145/237170.237244): convex polyhedra are separate if and only if they are so along a
// face's normal or across an edge of each.
template <class Visit>
class Axes {
 public:
  Axes(const Placed& first, const Placed& second, Visit& visit)
      : first_(first), second_(second), visit_(visit) {}

  void run() {
    each_face(first_, Source::face_of_first), each_face(second_, Source::face_of_second);
    for (const Core::Edge& e : first_.core->edges) {
      const Vec3 u = first_.corner(e[1]) - first_.corner(e[0]);
      for (const Core::Edge& g : second_.core->edges) {
        const Vec3 v = second_.corner(g[1]) - second_.corner(g[0]);
        visit_axis({Source::edges, u.cross(v), u, v});
      }
    }
    if (plane_.isZero()) return;
    // In a plane the normals are those of sides, and they rotate with their body like those of a
    // face.
    each_side(first_, Source::face_of_first), each_side(second_, Source::face_of_second);
  }

 private:
  void each_face(const Placed& p, Source source) {
    for (const Core::Triangle& t : p.core->triangles) {
      const Vec3 a = p.corner(t[0]);
      visit_axis({source, (p.corner(t[1]) - a).cross(p.corner(t[2]) - a)});
    }
  }
  void each_side(const Placed& p, Source source) {
    for (const Core::Edge& e : p.core->edges)
      visit_axis({source, plane_.cross(p.corner(e[1]) - p.corner(e[0]))});
  }
  void visit_axis(const Axis& axis) {
    // Far above the rounding of corners, far below any relevant overlap.
    const double flat = 1e-12 * (first_.radius + second_.radius);  // rounding
    const double length = axis.along.norm();
    // Parallel edges or a triangle without area: no axis.
    if (!(length > 1e-300)) return;
    const Vec3 n = axis.along / length;
    const double ahead = slab_width(first_, second_, n), behind = slab_width(first_, second_, -n);
    if (std::max(std::abs(ahead), std::abs(behind)) < flat) {
      plane_ = n;
      return;
    }
    visit_(Slab{n, ahead}, axis), visit_(Slab{-n, behind}, axis);
  }

  const Placed &first_, &second_;
  Visit& visit_;
  Vec3 plane_ = Vec3::Zero();
};

Mat3 cross_matrix(const Vec3& n) {
  return Mat3{{0, -n.z(), n.y()}, {n.z(), 0, -n.x()}, {-n.y(), n.x(), 0}};
}

// With x_i, x_j the corners that bound the slab, width = n . (x_j - x_i). While i rotates by a, x_i
// moves by a x x_i and n by dn = swing a:
//   d width = -n . (a x x_i) + dn . (x_j - x_i) = (n x x_i + swing^T (x_j - x_i)) . a.
// The normal of a face of i rotates with it, dn = a x n; that of a face of j does not; of crossed
// edges u of i rotates and v of j does not.
SeparationDirection separation_direction(const Placed& first, const Placed& second,
                                         const Slab& slab, const Axis& axis) {
  const Vec3& n = slab.normal;
  SeparationDirection direction{slab, Vec3::Zero(), Mat3::Zero(), 1, Vec3::Zero()};
  if (axis.source == Source::face_of_first) direction.swing = -cross_matrix(n);
  if (axis.source == Source::edges) {
    // d (u x v) = (a x u) x v = (u v^T - (u . v)) a
    const Mat3 change = axis.u * axis.v.transpose() - axis.u.dot(axis.v) * Mat3::Identity();
    const double sign = n.dot(axis.along) > 0 ? 1 : -1, length2 = axis.along.squaredNorm();
    direction.swing = sign / std::sqrt(length2) * (Mat3::Identity() - n * n.transpose()) * change;
    const double over = 1 / (axis.u.squaredNorm() * axis.v.squaredNorm());
    // sin^2 of the angle between u and v: |u x v|^2 / (|u|^2 |v|^2).
    direction.sine2 = over * length2;
    direction.sharpens = 2 * over * (change.transpose() * axis.along);
  }
  const Vec3 on_first = first.corner(support(first, n).corner),
             on_second = second.corner(support(second, -n).corner);
  direction.moment = n.cross(on_first) + direction.swing.transpose() * (on_second - on_first);
  return direction;
}

}  // namespace

// Both directions along each axis: the order of the bodies is not known.
Slab separating_axis(const Placed& first, const Placed& second) {
  Slab best{Vec3::UnitX(), -std::numeric_limits<double>::infinity()};
  const auto visit = [&](const Slab& slab, const Axis&) {
    if (slab.width > best.width) best = slab;
  };
  Axes(first, second, visit).run();
  if (!std::isfinite(best.width)) best.width = 0;  // points and segments have no inside
  return best;
}

void separation_directions(const Placed& first, const Placed& second, double least,
                           std::vector<SeparationDirection>& directions) {
  directions.clear();
  const auto visit = [&](const Slab& slab, const Axis& axis) {
    if (slab.width >= least) directions.push_back(separation_direction(first, second, slab, axis));
  };
  Axes(first, second, visit).run();
}

}  // namespace trackbed::dem
