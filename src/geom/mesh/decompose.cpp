// Approximate convex decomposition by repeated cutting.
//
// The best plane is found by trial: planes through the sharpest concave edges, planes across the
// three axes of the part, then a search with halving steps around the best. A cut costs a pass over
// the part's triangles and two hulls, some 150 trials per cut: a tenth of a second for a hundred
// triangles, ten for ten thousand. Exact convex decomposition (CGAL's, of Nef polyhedra) makes a
// part of every dent of a scan.
#include <algorithm>
#include <cmath>
#include <map>

#include "geom/convex/hull.hpp"
#include "geom/convex/mass.hpp"
#include "geom/mesh/part.hpp"

namespace trackbed::geom {

namespace {

// Planes to be tried at a concave edge: along one face, along the other, and between them.
struct Dent {
  Vec3 at;           // middle of a concave edge
  double depth = 0;  // length times sine of the angle
  std::array<Vec3, 3> normals;
};

// Sorting by depth times length puts the notch with the largest volume first.
std::vector<Dent> concave_edges(const Mesh& mesh) {
  // About one degree: below it the edge is a facet of something round, not a dent.
  constexpr double sharp = 0.02;  // sine of the least angle
  std::map<std::array<int, 2>, Vec3> normals;
  for (const auto& t : mesh.triangles) {
    const auto at = [&](std::size_t k) { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    const Vec3 n = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
    for (std::size_t k = 0; k < 3; ++k) normals[{t[k], t[(k + 1) % 3]}] = n;
  }
  std::vector<Dent> dents;
  for (const auto& [edge, n] : normals) {
    const auto other = normals.find({edge[1], edge[0]});
    if (edge[0] > edge[1] || other == normals.end()) continue;
    const Vec3 &a = mesh.vertices[static_cast<std::size_t>(edge[0])],
               &b = mesh.vertices[static_cast<std::size_t>(edge[1])];
    const Vec3 along = (b - a).normalized(), m = other->second;
    const double sine = -n.cross(m).dot(along);  // positive if the surface turns towards itself
    if (sine > sharp)
      dents.push_back(
          {(a + b) / 2, sine * (b - a).norm(), {n, m, along.cross(n + m).normalized()}});
  }
  std::stable_sort(dents.begin(), dents.end(),
                   [](const Dent& a, const Dent& b) { return a.depth > b.depth; });
  return dents;
}

// Concave edges of the whole mesh within the part, the deepest first; then planes across its
// principal axes, for parts whose concavity has no sharp edge.
std::vector<Plane> candidates(const Part& part, const std::vector<Dent>& dents) {
  // These bound the time of a cut.
  constexpr std::size_t edges = 20;
  constexpr int slices = 8;
  std::vector<Plane> planes;
  for (const Dent& dent : dents) {
    const bool within = std::all_of(part.planes.begin(), part.planes.end(),
                                    [&](const Plane& p) { return p.height(dent.at) > 0; });
    if (!within || planes.size() >= 3 * edges) continue;
    for (const Vec3& normal : dent.normals) planes.push_back({normal, normal.dot(dent.at)});
  }
  Integrals sums;
  for (const auto* side : {&part.skin, &part.caps})
    for (const auto& [a, b, c] : *side) add_tetrahedron(a, b, c, sums);
  const Mat3 axes = solid_of(sums).axes.toRotationMatrix();
  for (int k = 0; k < 3; ++k) {
    const Vec3 axis = axes.col(k);
    double low = axis.dot(part.corners[0]), high = low;
    for (const Vec3& p : part.corners)
      low = std::min(low, axis.dot(p)), high = std::max(high, axis.dot(p));
    for (int s = 1; s < slices; ++s) planes.push_back({axis, low + (high - low) * s / slices});
  }
  return planes;
}

struct Cut {
  Plane plane;
  std::pair<Part, Part> parts;
  double concavity = 0;
};

// Best of several planes, starting from the present state. Greedy: only the next cut is assessed,
// not what later cuts could make of it.
class Search {
 public:
  Search(const Mesh& mesh, const Part& part) : mesh_(mesh), part_(part) {
    best_.concavity = part.concavity();
  }
  // Whether the plane is better than the best one up to now by the fraction `gain`.
  bool attempt(const Plane& plane, double gain = 0) {
    // A cut that removes nearly nothing would count as a part without benefit.
    constexpr double sliver = 1e-4;  // of the volume
    auto parts = cut(part_, plane, mesh_);
    if (std::min(parts.first.volume, parts.second.volume) < sliver * part_.volume) return false;
    const double concavity = parts.first.concavity() + parts.second.concavity();
    // For convex parts the difference is a rounding error of either sign. A gain of less than
    // `noise` does not count: a refinement would never end, and of equally good planes another than
    // the first would be chosen.
    constexpr double noise = 1e-9;  // of the volume
    const double least = gain * std::max(best_.concavity, 0.0) + noise * part_.volume;
    if (concavity >= best_.concavity - least) return false;
    best_ = {plane, std::move(parts), concavity};
    found_ = true;
    return true;
  }
  // Steps are tilts in radians and shifts in extents, halved from 0.06 to 0.0075; each gain
  // restarts the pass at the same step.
  void refine() {
    constexpr double gain = 0.02;  // below it a search takes more time than it is worth
    const double extent = extent_of(part_.corners);
    for (double step = 0.06; found_ && step > 0.005; step /= 2)
      for (bool better = true; better;) {
        better = false;
        const Plane from = best_.plane;
        const Vec3 u = from.normal.unitOrthogonal(), v = from.normal.cross(u);
        double middle = 0;  // tilts are about the middle of the part
        for (const Vec3& p : part_.corners)
          middle += from.height(p) / static_cast<double>(part_.corners.size());
        const Vec3 pivot = mean() - middle * from.normal;
        for (const Vec3& tilt : {Vec3(u), Vec3(v), Vec3(-u), Vec3(-v)}) {
          const Vec3 normal = (from.normal + step * tilt).normalized();
          better = attempt({normal, normal.dot(pivot)}, gain) || better;
        }
        for (const double shift : {-step * extent, step * extent})
          better = attempt({from.normal, from.offset + shift}, gain) || better;
      }
  }
  bool found() const { return found_; }
  Cut& best() { return best_; }

 private:
  Vec3 mean() const {
    Vec3 sum = Vec3::Zero();
    for (const Vec3& p : part_.corners) sum += p / static_cast<double>(part_.corners.size());
    return sum;
  }
  const Mesh& mesh_;
  const Part& part_;
  Cut best_;
  bool found_ = false;
};

// Replaces the least convex part by two; false if there is no gain.
bool cut_worst(const Mesh& mesh, const std::vector<Dent>& dents, double allowed,
               std::vector<Part>& parts) {
  const auto worst = std::max_element(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
    return a.concavity() < b.concavity();
  });
  if (worst->concavity() < allowed) return false;
  Search search(mesh, *worst);
  for (const Plane& plane : candidates(*worst, dents)) search.attempt(plane);
  search.refine();
  if (!search.found()) return false;
  auto [above, below] = std::move(search.best().parts);
  *worst = std::move(above);
  parts.push_back(std::move(below));
  return true;
}

// A hull with few corners has less volume; it is enlarged about its centroid to the volume of the
// part's hull, so that the centre of mass is kept to first order. Neighbours may then overlap a
// little; the union counts that once.
Convex with_corners(const Part& part, int vertices) {
  const Convex core = reduced_hull(part.corners, vertices);
  const Solid solid = piece_solid({core, 0});
  const Convex grown = scaled(moved(core, Quat::Identity(), -solid.centre),
                              std::cbrt(part.hull_volume / solid.volume));
  return moved(grown, Quat::Identity(), solid.centre);
}

}  // namespace

Decomposition decompose(const Mesh& mesh, int parts, int vertices) {
  constexpr double convex = 1e-3;  // of the volume: a part with less concavity is not cut
  constexpr int cells = 192;
  std::vector<Part> made{whole_part(mesh)};
  const double volume = made[0].volume;
  const std::vector<Dent> dents = concave_edges(mesh);
  while (static_cast<int>(made.size()) < parts)
    if (!cut_worst(mesh, dents, convex * volume, made)) break;
  Decomposition result;
  std::vector<Piece> pieces;
  for (const Part& part : made) {
    result.pieces.push_back(with_corners(part, vertices));
    pieces.push_back({result.pieces.back(), 0});
  }
  // The volume of one piece is exact; for several it is that of the union by lines, whose error of
  // 0.04 % is below the reported accuracy.
  const double all =
      pieces.size() == 1 ? piece_solid(pieces[0]).volume : union_solid(pieces, cells).volume;
  result.volume_error = all / volume - 1;
  return result;
}

}  // namespace trackbed::geom
