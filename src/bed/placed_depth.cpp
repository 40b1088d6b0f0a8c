// Positions of stones within surfaces that contact detection cannot detect. A contact needs the
// closest point of a surface: a body that is through a plate by more than a radius, or wholly
// inside a box, has none.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "trackbed/bed/placed.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::bed {

namespace {

using Polygon = std::vector<Vec3>;

constexpr double infinite = std::numeric_limits<double>::infinity();

Polygon corners_of(const Surface& surface, std::size_t triangle) {
  Polygon corners;
  for (const std::int32_t node : surface.triangles[triangle])
    corners.push_back(surface.position[static_cast<std::size_t>(node)]);
  return corners;
}

Vec3 normal_of(const Polygon& triangle) {
  return (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).normalized();
}

// The part of the polygon below the plane (Sutherland, Hodgman 1974, doi:10.1145/360767.360802).
Polygon cut_to(const Polygon& polygon, const geom::Face& face) {
  Polygon left;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vec3 &from = polygon[k], &to = polygon[(k + 1) % polygon.size()];
    const double a = face.normal.dot(from) - face.offset, b = face.normal.dot(to) - face.offset;
    if (a <= 0) left.push_back(from);
    if ((a < 0 && b > 0) || (a > 0 && b < 0)) left.push_back(from + a / (a - b) * (to - from));
  }
  return left;
}

bool cuts(const Polygon& triangle, const geom::Convex& core) {
  Polygon left = core.faces.empty() ? Polygon{} : triangle;
  for (const geom::Face& face : core.faces) left = cut_to(left, face);
  return !left.empty();
}

// m, displacement along the triangle's normal that brings the piece in front of it.
double exit_distance(const geom::Piece& piece, const Polygon& triangle) {
  const Vec3 n = normal_of(triangle);
  double deepest = -infinite;
  for (const Vec3& corner : piece.core.vertices)
    deepest = std::max(deepest, n.dot(triangle[0] - corner));
  return deepest + piece.radius;
}

// A plate encloses nothing: a position behind it is allowed.
bool is_closed(const Surface& surface) { return surface.triangles.size() > 2; }

double depth_of(const geom::Piece& piece, const Surface& surface) {
  double through = infinite, inside = infinite;
  bool enclosed = is_closed(surface);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Polygon triangle = corners_of(surface, t);
    const double distance = exit_distance(piece, triangle);
    if (cuts(triangle, piece.core)) through = std::min(through, distance);
    const Vec3 n = normal_of(triangle);
    for (const Vec3& corner : piece.core.vertices)
      enclosed = enclosed && n.dot(corner - triangle[0]) < 0;
    inside = std::min(inside, distance);
  }
  if (through < infinite) return through;
  return enclosed ? inside : 0;
}

}  // namespace

double penetration_depth(const std::vector<geom::Piece>& pieces, const Surface& surface) {
  double deepest = 0;
  for (const geom::Piece& piece : pieces) deepest = std::max(deepest, depth_of(piece, surface));
  return deepest;
}

std::vector<geom::Piece> pieces_in_space(const PlacedShape& shape, const StoneParameters& stone) {
  const Quat turn = turn_of(stone.axis, stone.angle) * shape.axes;
  std::vector<geom::Piece> pieces;
  for (const geom::Piece& piece : shape.shape.pieces)
    pieces.push_back(
        {geom::moved(geom::scaled(piece.core, shape.scale), turn, vector_of(stone.position)),
         piece.radius * shape.scale});
  return pieces;
}

// A point in a container is in front of all its walls, and outside of it behind at least one. A
// point in a body is behind all its faces.
bool is_behind(const Vec3& point, const Surface& surface) {
  std::size_t behind = 0;
  double sum = 0;  // sum of distances along the normals from the middle; above 0: a body
  Vec3 middle = Vec3::Zero();
  for (const Vec3& node : surface.position) middle += node / static_cast<double>(surface.nodes());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Polygon triangle = corners_of(surface, t);
    const Vec3 n = normal_of(triangle);
    sum += n.dot(triangle[0] - middle);
    if (n.dot(point - triangle[0]) < 0) ++behind;
  }
  const bool body = is_closed(surface) && sum > 0;
  return body ? behind == surface.triangles.size() : behind > 0;
}

namespace {

// s, times at which a point h m above a plane, with velocity c m/s away from it and acceleration g
// m/s^2 towards it, reaches the plane: the roots of h + c t - g/2 t^2 = 0, the earlier one first if
// g > 0. Below 0: never.
std::array<double, 2> times_in_plane(double h, double c, double g) {
  if (g == 0) return {c != 0 ? -h / c : -1, -1};
  const double square = c * c + 2 * g * h;
  if (square < 0) return {-1, -1};
  return {(c - std::sqrt(square)) / g, (c + std::sqrt(square)) / g};
}

bool is_over(const Polygon& triangle, const Vec3& point) {
  const Vec3 n = normal_of(triangle);
  for (std::size_t e = 0; e < 3; ++e)
    if (n.dot((triangle[(e + 1) % 3] - triangle[e]).cross(point - triangle[e])) < 0) return false;
  return true;
}

// m, largest depth of a corner behind a surface at which the piece is in contact with it.
double reach_behind(const geom::Piece& piece) {
  const std::vector<Vec3>& corners = piece.core.vertices;
  Vec3 middle = Vec3::Zero();
  for (const Vec3& corner : corners) middle += corner / static_cast<double>(corners.size());
  double ball = 0;
  for (const Vec3& corner : corners) ball = std::max(ball, (corner - middle).norm());
  return std::max(piece.radius, dem::largest_corner_depth * (ball + piece.radius));
}

}  // namespace

// Each corner with its sphere follows its parabola; the first triangle it reaches from either side
// counts, or one that it touches from the beginning.
std::optional<Impact> first_impact(const std::vector<geom::Piece>& pieces, const Flight& flight,
                                   const PlacedSurfaces& placed, double until) {
  std::optional<Impact> first;
  const auto follow = [&](const Vec3& corner, double radius, double behind, std::size_t k,
                          const Polygon& triangle) {
    const Vec3 n = normal_of(triangle), velocity = flight.velocity - placed.velocity(k);
    const double h = n.dot(corner - triangle[0]), c = n.dot(velocity);
    const double g = flight.gravity * n.z();
    if (h <= radius && h >= -behind && is_over(triangle, corner)) first = {k, 0, false};
    for (const bool from_behind : {false, true}) {
      for (const double time : times_in_plane(from_behind ? h + behind : h - radius, c, g)) {
        const bool along_normal = c - g * time > 0;
        if (along_normal != from_behind || !(time > 0)) continue;
        if (time > (first ? std::min(until, first->time) : until)) continue;
        const Vec3 fall(0, 0, -flight.gravity * time * time / 2);
        if (is_over(triangle, corner + time * velocity + fall)) first = {k, time, from_behind};
      }
    }
  };
  for (std::size_t k = 0; k < placed.surfaces().size(); ++k) {
    const Surface& surface = placed.surfaces()[k];
    for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
      const Polygon triangle = corners_of(surface, t);
      for (const geom::Piece& piece : pieces) {
        const double behind = reach_behind(piece);
        for (const Vec3& corner : piece.core.vertices)
          follow(corner, piece.radius, behind, k, triangle);
      }
    }
  }
  return first;
}

}  // namespace trackbed::bed
