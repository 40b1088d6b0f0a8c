// Stones and cores cut by planes.
#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "trackbed/geom/stone.hpp"

namespace trackbed::geom {

namespace {

// Corners this near to a plane, over the length of the core along its normal, are on it: edges that
// cross it there would give corners that a hull cannot tell apart.
constexpr double on_plane = 1e-6;

double near_plane(const Convex& core, const Vec3& normal) {
  return on_plane * (support_of(core, normal) + support_of(core, -normal));
}

// Where the edges of a core cross the plane normal . x = offset.
std::vector<Vec3> crossings(const Convex& core, const Vec3& normal, double offset) {
  std::vector<Vec3> points;
  const double near = near_plane(core, normal);
  for (const Edge& edge : core.edges) {
    const Vec3 &a = core.vertices[static_cast<std::size_t>(edge.vertices[0])],
               &b = core.vertices[static_cast<std::size_t>(edge.vertices[1])];
    const double ha = normal.dot(a) - offset, hb = normal.dot(b) - offset;
    if (std::min(ha, hb) < -near && std::max(ha, hb) > near)
      points.push_back(a + ha / (ha - hb) * (b - a));
  }
  return points;
}

// Of the volume of the whole core and of its length across the plane: less is a sliver whose faces
// have no reliable normals.
constexpr double least_part = 1e-3;

// Its core shrunk by this part towards the centroid, with all its corners and faces; the rounding
// grows by as much as the nearest face recedes.
Piece rounder(const Piece& piece, double part) {
  const Vec3 middle = piece_solid({piece.core, 0}).centre;
  Piece found = piece;
  double nearest = std::numeric_limits<double>::infinity();
  for (Vec3& v : found.core.vertices) v -= part * (v - middle);
  for (Face& face : found.core.faces) {
    const double distance = face.offset - face.normal.dot(middle);
    face.offset -= part * distance;
    nearest = std::min(nearest, distance);
  }
  found.radius += part * nearest;
  return found;
}

void require_faces(const Template& stone) {
  for (const Piece& piece : stone.pieces)
    if (piece.core.vertices.size() < 4)
      throw std::invalid_argument("only stones of polyhedra can be cut or worn");
}

constexpr int cells = 48;  // of unions: volume to 1e-3 or better

}  // namespace

double support_of(const Convex& core, const Vec3& normal) {
  double most = -std::numeric_limits<double>::infinity();
  for (const Vec3& v : core.vertices) most = std::max(most, normal.dot(v));
  return most;
}

double support_of(const Template& stone, const Vec3& normal) {
  double most = -std::numeric_limits<double>::infinity();
  for (const Piece& piece : stone.pieces)
    most = std::max(most, support_of(piece.core, normal) + piece.radius);
  return most;
}

// Hull of the corners below and of the points where edges cross the plane: exact for a convex core,
// and no face has to be clipped.
Convex core_below(const Convex& core, const Vec3& normal, double offset) {
  std::vector<Vec3> points;
  const double near = near_plane(core, normal);
  for (const Vec3& v : core.vertices)
    if (normal.dot(v) <= offset + near) points.push_back(v);
  for (const Vec3& point : crossings(core, normal, offset)) points.push_back(point);
  return convex_hull(points);
}

// The section is convex, so its corners follow each other by their angle about its middle.
double section_area(const Convex& core, const Vec3& normal, double offset) {
  std::vector<Vec3> points = crossings(core, normal, offset);
  const double near = near_plane(core, normal);
  for (const Vec3& v : core.vertices)
    if (std::abs(normal.dot(v) - offset) <= near) points.push_back(v);
  if (points.size() < 3) return 0;
  Vec3 middle = Vec3::Zero();
  for (const Vec3& point : points) middle += point / static_cast<double>(points.size());
  const Vec3 across = normal.unitOrthogonal(), along = normal.cross(across);
  const auto angle = [&](const Vec3& point) {
    return std::atan2(along.dot(point - middle), across.dot(point - middle));
  };
  std::sort(points.begin(), points.end(),
            [&](const Vec3& a, const Vec3& b) { return angle(a) < angle(b); });
  double twice = 0;
  for (std::size_t k = 0; k < points.size(); ++k)
    twice += normal.dot((points[k] - middle).cross(points[(k + 1) % points.size()] - middle));
  return twice / 2;
}

std::optional<StonePart> part_below(const Template& whole, const Vec3& normal, double offset) {
  require_faces(whole);
  std::vector<Piece> pieces;
  for (const Piece& piece : whole.pieces) {
    const double plane = offset - piece.radius;
    if (support_of(piece.core, normal) <= plane) {
      pieces.push_back(piece);
      continue;
    }
    const double low = -support_of(piece.core, -normal);
    if (plane - low < least_part * (support_of(piece.core, normal) - low)) continue;
    Piece part{core_below(piece.core, normal, plane), piece.radius};
    if (steiner_of(part.core).volume > least_part * steiner_of(piece.core).volume)
      pieces.push_back(std::move(part));
  }
  if (pieces.empty()) return {};
  const Solid solid = pieces.size() == 1 ? piece_solid(pieces[0]) : union_solid(pieces, cells);
  return StonePart{template_of(pieces, solid, 0), solid.centre, solid.axes};
}

std::vector<Joint> joints_of(const Template& stone) {
  std::vector<Joint> found;
  for (const Piece& piece : stone.pieces)
    for (const Face& face : piece.core.faces) {
      bool below = false, above = false, cut = false;
      for (const Piece& other : stone.pieces) {
        const double high = support_of(other.core, face.normal) - face.offset;
        const double low = -support_of(other.core, -face.normal) - face.offset;
        const double allowed = least_part * (high - low);
        const bool under = high <= allowed, over = low >= -allowed;
        below = below || under, above = above || over, cut = cut || (!under && !over);
      }
      if (!below || !above || cut) continue;
      const bool known = std::any_of(found.begin(), found.end(), [&](const Joint& joint) {
        const double side = joint.normal.dot(face.normal);
        return std::abs(side) > 1 - on_plane &&
               std::abs(joint.offset - std::copysign(face.offset, side * face.offset)) <=
                   near_plane(piece.core, face.normal);
      });
      if (!known) found.push_back({face.normal, face.offset});
    }
  return found;
}

std::optional<StonePart> worn(const Template& whole, double volume) {
  require_faces(whole);
  if (whole.pieces.size() != 1) throw std::invalid_argument("only stones of one piece wear");
  const Piece& piece = whole.pieces[0];
  const double before = piece_solid(piece).volume;
  const auto missing = [&](double part) {  // m^3, still to be taken off
    return volume - (before - piece_solid(rounder(piece, part)).volume);
  };
  constexpr double most = 0.9;  // less of a core is too small for reliable normals
  if (!(missing(most) < 0)) return {};
  constexpr int bits = 30;  // of `part`; the volume is set below
  std::uintmax_t steps = 60;
  const double part =
      boost::math::tools::toms748_solve(missing, 0.0, most,
                                        boost::math::tools::eps_tolerance<double>(bits), steps)
          .first;
  const Piece rest = rounder(piece, part);
  const Solid solid = piece_solid(rest);
  StonePart found{template_of({rest}, solid, whole.sieve), solid.centre, solid.axes};
  found.stone.volume = whole.volume - volume;
  return found;
}

}  // namespace trackbed::geom
