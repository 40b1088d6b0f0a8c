// Meshes from files, repaired or refused; CGAL repairs and checks.
//
// A scan is rarely a valid surface. Defects that can be repaired without a guess about the shape
// are repaired and reported; others are refused with a reason. The order matters: facets are
// cleaned and oriented before there is a surface at all (CGAL's half-edge mesh requires it), specks
// are removed before holes are closed (their holes do not count), and the checks come last, on the
// mesh to be used.
#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Polygon_mesh_processing/stitch_borders.h>
#include <CGAL/Polygon_mesh_processing/triangulate_faces.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "geom/convex/hull.hpp"
#include "geom/convex/kernel.hpp"
#include "geom/convex/refusal.hpp"
#include "geom/mesh/soup.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/geom/mesh.hpp"

namespace trackbed::geom {

namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

// Specks from a scanner are far smaller, a second stone is far larger.
constexpr double speck = 0.01;  // of the surface
// A hole with this border is about a tenth of the stone wide: a flat lid over it changes the volume
// little. Where a stone lay on a table the hole is larger, and its shape unknown.
constexpr double hole = 0.3;  // perimeter, of the extent

// Reason why a mesh cannot be used; the caller adds its name.
// Also catches a wrong `unit`, and keeps cubes of lengths far from overflow.
void scale(std::vector<Vec3>& points, double unit) {
  constexpr double largest = 1e6;  // m
  for (Vec3& p : points) {
    p *= unit;
    for (const double at : p)
      if (!(std::abs(at) <= largest))
        refuse(
            fmt::format("a coordinate is {:g} m; coordinates must be numbers of at most 1000 km in "
                        "magnitude; is the length unit right?",
                        at));
  }
}

// Cleaning leaves facets out, and cuts those that return to one of their corners. Only the
// resulting number is known: the message states which of the two prevails, and by how many.
std::string cleaned(std::size_t before, std::size_t after) {
  return after > before
             ? fmt::format("self-touching facets were split, which gives {} facets more",
                           after - before)
             : fmt::format("facets removed, because they have no area or are duplicates: {}",
                           before - after);
}

// A message per kind of repair is appended to `repairs`.
Surface joined(Soup& soup, std::vector<std::string>& repairs) {
  const std::size_t polygons = soup.polygons.size();
  std::vector<Kernel::Point_3> points;
  for (const Vec3& p : soup.points) points.emplace_back(p.x(), p.y(), p.z());
  pmp::repair_polygon_soup(points, soup.polygons);
  if (soup.polygons.size() != polygons) repairs.push_back(cleaned(polygons, soup.polygons.size()));
  if (!pmp::orient_polygon_soup(points, soup.polygons))
    repairs.push_back("non-manifold edges (of more than two facets) or vertices were split");
  if (!pmp::is_polygon_soup_a_polygon_mesh(soup.polygons))
    refuse("the facets do not form a surface; repair it in a mesh editor, for example MeshLab");
  Surface surface;
  pmp::polygon_soup_to_polygon_mesh(points, soup.polygons, surface);
  if (!pmp::triangulate_faces(surface)) refuse("a facet cannot be cut into triangles");
  // Only edges whose ends have equal coordinates: merging points that are merely close would be a
  // guess about the shape.
  if (const std::size_t edges = pmp::stitch_borders(surface); edges > 0)
    repairs.push_back(fmt::format("pairs of equal border edges joined: {}", edges));
  return surface;
}

// The largest body; others must be specks. By area, not volume: parts may still be open here.
Surface largest_part(const Surface& surface, std::vector<std::string>& repairs) {
  std::vector<Surface> parts;
  pmp::split_connected_components(surface, parts);
  if (parts.empty()) refuse("the mesh has no facets");
  const auto largest =
      std::max_element(parts.begin(), parts.end(),
                       [](const auto& a, const auto& b) { return pmp::area(a) < pmp::area(b); });
  const double allowed = speck * pmp::area(*largest);
  for (auto part = parts.begin(); part != parts.end(); ++part)
    if (part != largest && pmp::area(*part) > allowed)
      refuse(fmt::format("the mesh has {} separate surfaces; a file must contain one body",
                         parts.size()));
  if (parts.size() > 1)
    repairs.push_back(
        fmt::format("separate surfaces left out: {} (each at most {:g} % of the area)",
                    parts.size() - 1, 100 * speck));
  return std::move(*largest);
}

// The patch consists of triangles over the vertices of the border, without new points.
void close_holes(Surface& surface, double extent, std::vector<std::string>& repairs) {
  std::vector<Surface::Halfedge_index> borders;
  pmp::extract_boundary_cycles(surface, std::back_inserter(borders));
  for (const auto border : borders) {
    const double length = pmp::face_border_length(border, surface);
    if (length > hole * extent)
      refuse(
          fmt::format("the mesh is not closed: a hole has a border of {:.3g} m; the program fills "
                      "only holes with a border of at most {:.3g} m ({:g} times the extent of the "
                      "mesh)",
                      length, hole * extent, hole));
    std::vector<Surface::Face_index> patch;
    pmp::triangulate_hole(surface, border, std::back_inserter(patch));
    if (patch.empty())
      refuse(
          "the mesh is not closed, and a hole cannot be filled; repair it in a mesh editor, for "
          "example MeshLab");
  }
  if (!borders.empty()) repairs.push_back(fmt::format("small holes closed: {}", borders.size()));
}

// Checked before any repair: the two sides of a flat mesh would be found to intersect. From the
// least extent of the points in any direction, whose square is the eigenvalue.
void require_depth(const std::vector<Vec3>& points, double extent) {
  constexpr double sheet = 1e-7;  // of the extent; the eigenvalues are good to 1e-16 of its square
  Vec3 mean = Vec3::Zero();
  for (const Vec3& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vec3& p : points) spread += (p - mean) * (p - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread, Eigen::EigenvaluesOnly);
  if (!(axes.eigenvalues()[0] > sheet * sheet * extent * extent))
    refuse("the mesh is flat; use a scan of the whole stone");
}

// Closed, then free of self-intersections, then outward: each requires the one before. Mass is
// derived from the volume.
void check(Surface& surface, double extent) {
  // Below it the inertia is dominated by rounding, and no stone is that thin.
  constexpr double flat = 1e-9;  // of the extent cubed
  if (!CGAL::is_closed(surface))
    refuse("the mesh is not closed; repair it in a mesh editor, for example MeshLab");
  if (pmp::does_self_intersect(surface))
    refuse("the mesh intersects itself; repair it in a mesh editor, for example MeshLab");
  pmp::orient_to_bound_a_volume(surface);
  if (!(pmp::volume(surface) > flat * extent * extent * extent))
    refuse("the mesh has no volume; use a scan of the whole stone");
}

// Removed vertices leave gaps in CGAL's numbering; ours has none.
Mesh mesh_of(const Surface& surface) {
  Mesh mesh;
  std::vector<int> number(surface.num_vertices() + surface.number_of_removed_vertices(), -1);
  for (const auto v : surface.vertices()) {
    number[v] = static_cast<int>(mesh.vertices.size());
    const auto& p = surface.point(v);
    mesh.vertices.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto f : surface.faces()) {
    Triangle triangle{};
    std::size_t k = 0;
    for (const auto v : surface.vertices_around_face(surface.halfedge(f)))
      triangle[k++] = number[v];
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

}  // namespace

// CGAL reports violated preconditions as exceptions of its own, whose texts do not help a user.
Import import_mesh(const std::string& bytes, MeshFormat format, double unit,
                   const std::string& name) {
  try {
    Soup soup = read_soup(bytes, format);
    scale(soup.points, unit);
    const double extent = extent_of(soup.points);
    require_depth(soup.points, extent);
    Import import;
    Surface surface = largest_part(joined(soup, import.repairs), import.repairs);
    close_holes(surface, extent, import.repairs);
    check(surface, extent);
    import.mesh = mesh_of(surface);
    return import;
  } catch (const CGAL::Failure_exception&) {
    throw InputError({name + ": the mesh is too damaged for the repairs that this program makes; "
                             "repair it in a mesh editor, for example MeshLab"});
  } catch (const std::exception& error) {  // lengths and counts of a broken file, too
    throw InputError({name + ": " + error.what()});
  }
}

}  // namespace trackbed::geom
