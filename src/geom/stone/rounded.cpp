// Volume, surface and inertia of a rounded convex piece, exactly.
//
// The swept solid consists of the core, a prism on each face, a sector of a cylinder along each
// edge and a sector of a ball at each corner (Steiner's formula is the sum of their volumes). The
// directions at a corner fill a spherical polygon between the normals of its faces; its integrals
// of n and n n^T follow from those along its arcs, since both are spherical harmonics h with
// Laplacian -2 h and -6 h, apart from a constant.
//
// Cost: one pass over faces and edges. Symbols: r radius of rounding, m; n unit outward normal;
// theta angle between the normals of an edge's faces. (Steiner's formula and its parts: Schneider
// 2013, Convex Bodies, doi:10.1017/CBO9781139003858.)
#include <cmath>
#include <numbers>

#include "geom/convex/mass.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::geom {

namespace {

using std::numbers::pi;

Mat3 twice_symmetric(const Vec3& a, const Vec3& b) { return a * b.transpose() + b * a.transpose(); }

// The sector between the normals of the two faces of an edge.
struct Arc {
  double length, angle;  // of the edge, m; between the normals
  Vec3 along;            // unit, first vertex to second
  Vec3 n;                // integral of the outward direction over the angle
  Mat3 nn;               // of its square
};

// Directions are n(phi) = from cos(phi) + aside sin(phi), phi from 0 to the angle; their integrals
// in closed form. Faces in one plane give an angle of 0, which adds nothing; max() covers a convex
// edge that rounding made concave.
Arc arc_of(const Convex& core, const Edge& edge) {
  Arc arc;
  arc.along = core.vertices[static_cast<std::size_t>(edge.vertices[1])] -
              core.vertices[static_cast<std::size_t>(edge.vertices[0])];
  arc.length = arc.along.norm();
  arc.along /= arc.length;
  const bool alone = edge.faces[0] < 0;  // a segment: all around
  const Vec3 from = alone ? arc.along.unitOrthogonal()
                          : core.faces[static_cast<std::size_t>(edge.faces[0])].normal;
  const Vec3 aside = arc.along.cross(from).normalized();  // away from the first face
  arc.angle = 2 * pi;
  if (!alone) {
    const Vec3& to = core.faces[static_cast<std::size_t>(edge.faces[1])].normal;
    arc.angle = std::atan2(std::max(0.0, to.dot(aside)), to.dot(from));
  }
  const double c = std::cos(arc.angle), s = std::sin(arc.angle);
  arc.n = s * from + (1 - c) * aside;
  arc.nn = (arc.angle + s * c) / 2 * from * from.transpose() +
           (arc.angle - s * c) / 2 * aside * aside.transpose() +
           s * s / 2 * twice_symmetric(from, aside);
  return arc;
}

// Points y + t n, y in the triangle, t from 0 to r. `first` and `second` are the triangle's own
// integrals of y and y y^T.
void add_prism(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& n, double r,
               Integrals& sums) {
  const double area = (b - a).cross(c - a).dot(n) / 2;
  const Vec3 s = a + b + c, first = area / 3 * s;
  const Mat3 second =
      area / 12 * (s * s.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
  sums.volume += area * r;
  sums.first += r * first + r * r / 2 * area * n;
  sums.second +=
      r * second + r * r / 2 * twice_symmetric(first, n) + r * r * r / 3 * area * n * n.transpose();
}

// Points y + rho n(phi), y along the edge, rho from 0 to r, with rho drho dphi for the area. `line`
// and `square` are the edge's integrals of y and y y^T.
void add_sector(const Vec3& a, const Vec3& b, const Arc& arc, double r, Integrals& sums) {
  const double r2 = r * r / 2, r3 = r * r * r / 3, r4 = r * r * r * r / 4;
  const Vec3 line = arc.length / 2 * (a + b);
  const Mat3 square =
      arc.length * ((a * a.transpose() + b * b.transpose()) / 3 + twice_symmetric(a, b) / 6);
  sums.volume += arc.length * r2 * arc.angle;
  sums.first += r2 * arc.angle * line + arc.length * r3 * arc.n;
  sums.second +=
      r2 * arc.angle * square + r3 * twice_symmetric(line, arc.n) + arc.length * r4 * arc.nn;
}

// Directions of outward normals at a corner: solid angle and integrals of n, n n^T.
// With mu the normal of an arc that points out of the polygon and ds along it, both harmonics give
//   int n dA = -1/2 sum theta mu,   int (n n^T - 1/3) dA = -1/6 sum (mu N^T + N mu^T),
// where N is the arc's integral of n. The first is Lambert's formula of the light from a polygon.
struct Fan {
  double angle = 2 * pi;
  Vec3 n = Vec3::Zero();
  Mat3 nn = Mat3::Zero();  // without its trace
  void border(const Vec3& outward, const Arc& arc) {
    n -= arc.angle / 2 * outward;
    nn -= twice_symmetric(outward, arc.n) / 6;
  }
};

// Points at + rho n with rho^2 drho dA. The trace left out of `nn` is added here: n . n = 1.
void add_ball(const Vec3& at, const Fan& fan, double r, Integrals& sums) {
  const double r3 = r * r * r / 3, r4 = r * r * r * r / 4, r5 = r * r * r * r * r / 5;
  const double volume = r3 * fan.angle;
  sums.volume += volume;
  sums.first += volume * at + r4 * fan.n;
  sums.second += volume * at * at.transpose() + r4 * twice_symmetric(at, fan.n) +
                 r5 * (fan.nn + fan.angle / 3 * Mat3::Identity());
}

// By atan2: acos loses half its digits at flat corners.
double corner_angle(const Vec3& before, const Vec3& at, const Vec3& after) {
  const Vec3 a = before - at, b = after - at;
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// Flat cores and segments need no separate case: with their two faces, or the one edge, the fans
// have the right angles. A point has the whole sphere.
Integrals integrals_of(const Piece& piece, const Vec3& origin) {
  std::vector<Vec3> x = piece.core.vertices;
  for (Vec3& corner : x) corner -= origin;
  const auto at = [&](int k) -> const Vec3& { return x[static_cast<std::size_t>(k)]; };
  std::vector<Fan> fans(x.size());
  if (x.size() == 1) fans[0].angle = 4 * pi;
  Integrals sums;
  for (const Face& face : piece.core.faces) {
    const auto& loop = face.vertices;
    const std::size_t n = loop.size();
    for (std::size_t k = 1; k + 1 < n; ++k) {
      add_tetrahedron(at(loop[0]), at(loop[k]), at(loop[k + 1]), sums);
      add_prism(at(loop[0]), at(loop[k]), at(loop[k + 1]), face.normal, piece.radius, sums);
    }
    for (std::size_t k = 0; k < n; ++k)  // Gauss, Bonnet: the rest of a full turn after the faces
      fans[static_cast<std::size_t>(loop[k])].angle -=
          corner_angle(at(loop[(k + n - 1) % n]), at(loop[k]), at(loop[(k + 1) % n]));
  }
  for (const Edge& edge : piece.core.edges) {
    const Arc arc = arc_of(piece.core, edge);
    const auto [a, b] = edge.vertices;
    add_sector(at(a), at(b), arc, piece.radius, sums);
    fans[static_cast<std::size_t>(a)].border(arc.along, arc);
    fans[static_cast<std::size_t>(b)].border(-arc.along, arc);
  }
  for (std::size_t k = 0; k < x.size(); ++k) add_ball(x[k], fans[k], piece.radius, sums);
  return sums;
}

}  // namespace

Solid piece_solid(const Piece& piece) {
  Vec3 middle = Vec3::Zero();  // sums about a point inside avoid cancellation
  for (const Vec3& corner : piece.core.vertices) middle += corner;
  middle /= static_cast<double>(piece.core.vertices.size());
  Solid solid = solid_of(integrals_of(piece, middle));
  solid.centre += middle;
  return solid;
}

// Surface follows as the derivative by r: area + 2 bend r + 4 pi r^2.
Steiner steiner_of(const Convex& core) {
  Steiner s;
  s.volume = core.vertices.size() == 1 ? 0 : integrals_of({core, 0}, core.vertices[0]).volume;
  for (const Face& face : core.faces)
    for (std::size_t k = 1; k + 1 < face.vertices.size(); ++k) {
      const auto at = [&](std::size_t j) {
        return core.vertices[static_cast<std::size_t>(face.vertices[j])];
      };
      s.area += (at(k) - at(0)).cross(at(k + 1) - at(0)).dot(face.normal) / 2;
    }
  for (const Edge& edge : core.edges) {
    const Arc arc = arc_of(core, edge);
    s.bend += arc.length * arc.angle / 2;
  }
  return s;
}

double surface_area(const Piece& piece) {
  const Steiner s = steiner_of(piece.core);
  return s.area + 2 * s.bend * piece.radius + 4 * pi * piece.radius * piece.radius;
}

}  // namespace trackbed::geom
