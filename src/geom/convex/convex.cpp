// Convex cores from corners and faces, from which edges, normals and offsets follow.
//
// A core is checked as a whole when it is made, so that contacts never use an invalid one: closed,
// all faces outward, convex within the slack. Cost: faces times corners.
#include "trackbed/geom/convex.hpp"

#include <algorithm>
#include <map>
#include <stdexcept>

#include "geom/convex/hull.hpp"
#include "geom/convex/refusal.hpp"

namespace trackbed::geom {

namespace {

// Twice the area times the normal of a closed loop (Newell): all corners count, so a corner
// slightly off the plane has little effect. Its direction is the outward normal if the loop is
// counter-clockwise seen from outside.
Vec3 area_vector(const std::vector<Vec3>& at, const std::vector<int>& loop) {
  Vec3 sum = Vec3::Zero();
  const Vec3& origin = at[static_cast<std::size_t>(loop[0])];
  for (std::size_t k = 1; k + 1 < loop.size(); ++k)
    sum += (at[static_cast<std::size_t>(loop[k])] - origin)
               .cross(at[static_cast<std::size_t>(loop[k + 1])] - origin);
  return sum;
}

// The offset is that of the furthest corner in this direction, not the mean of the face's: `normal
// . x <= offset` then holds for all of the core, which bounds of distances rely on. The face is
// therefore outside of its corners by at most the slack.
Face face_of(const std::vector<Vec3>& vertices, const std::vector<int>& loop, double slack) {
  for (const int v : loop)
    if (v < 0 || static_cast<std::size_t>(v) >= vertices.size())
      refuse("a face refers to a corner that does not exist");
  if (loop.size() < 3) refuse("a face has less than three corners");
  Face face{loop, area_vector(vertices, loop), 0};
  if (!(face.normal.norm() > 0)) refuse("a face has no area");
  face.normal.normalize();
  double mean = 0;
  for (const int v : loop) mean += face.normal.dot(vertices[static_cast<std::size_t>(v)]);
  mean /= static_cast<double>(loop.size());
  face.offset = mean;
  for (const Vec3& corner : vertices) face.offset = std::max(face.offset, face.normal.dot(corner));
  if (face.offset > mean + slack) refuse("a corner is outside of a face: the body is not convex");
  return face;
}

// Each edge occurs twice, once in each direction, if the faces are closed and oriented
// consistently; anything else is refused. The map also makes the order of edges independent of that
// of the faces.
std::vector<Edge> edges_of(const std::vector<Face>& faces) {
  std::map<std::array<int, 2>, int> directed;  // (from, to) -> face
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const auto& loop = faces[f].vertices;
    for (std::size_t k = 0; k < loop.size(); ++k)
      if (!directed.insert({{loop[k], loop[(k + 1) % loop.size()]}, static_cast<int>(f)}).second)
        refuse("two faces have an edge in the same direction: orientations are inconsistent");
  }
  std::vector<Edge> edges;
  for (const auto& [edge, face] : directed) {
    const auto back = directed.find({edge[1], edge[0]});
    if (back == directed.end()) refuse("the faces are not closed");
    if (edge[0] < edge[1]) edges.push_back({edge, {face, back->second}});
  }
  return edges;
}

}  // namespace

double extent_of(const std::vector<Vec3>& points) {
  Vec3 low = points.at(0), high = low;
  for (const Vec3& p : points) low = low.cwiseMin(p), high = high.cwiseMax(p);
  return (high - low).norm();
}

// A point and a segment have no faces. The single edge of a segment then borders face -1 on both
// sides.
Convex assemble(std::vector<Vec3> vertices, const std::vector<std::vector<int>>& faces,
                double slack) {
  Convex core;
  if (vertices.empty()) refuse("there is no corner");
  for (const auto& loop : faces)
    core.faces.push_back(face_of(vertices, loop, slack * extent_of(vertices)));
  core.edges = edges_of(core.faces);
  if (faces.empty() && vertices.size() > 2) refuse("there is no face");
  if (faces.empty() && vertices.size() == 2) core.edges = {{{0, 1}, {-1, -1}}};
  // V - E + F = 2: one closed surface, all corners on it.
  if (!faces.empty() && vertices.size() + core.faces.size() != core.edges.size() + 2)
    refuse("the faces are not one closed surface with these corners");
  core.vertices = std::move(vertices);
  return core;
}

Convex convex_of(std::vector<Vec3> vertices, const std::vector<std::vector<int>>& faces) {
  // Corners from files have seven digits at least.
  constexpr double slack = 1e-6;
  return assemble(std::move(vertices), faces, slack);
}

Convex derived_again(const Convex& core) {
  std::vector<std::vector<int>> loops;
  for (const Face& face : core.faces) loops.push_back(face.vertices);
  return convex_of(core.vertices, loops);
}

Piece ball(const Vec3& centre, double radius) { return {{{centre}, {}, {}}, radius}; }

// Exact: the point of a ball furthest from the origin is on the line through its centre, beyond it.
double bounding_radius(const Template& shape) {
  double bound = 0;
  for (const Piece& piece : shape.pieces)
    for (const Vec3& corner : piece.core.vertices)
      bound = std::max(bound, corner.norm() + piece.radius);
  return bound;
}

}  // namespace trackbed::geom
