// Distances from a mesh by CGAL's tree of boxes.
//
// Distance: nearest triangle through the tree. Sign: parity of a ray's crossings, exact, so that no
// point next to the surface is taken to be inside. Each point needs about log n of n triangles.
#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Surface_mesh.h>

#include <cmath>

#include "geom/convex/kernel.hpp"
#include "trackbed/geom/mesh.hpp"

namespace trackbed::geom {

std::vector<double> depths(const Mesh& mesh, const std::vector<Vec3>& points) {
  using Surface = CGAL::Surface_mesh<Kernel::Point_3>;
  using Primitive = CGAL::AABB_face_graph_triangle_primitive<Surface>;
  using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;
  Surface surface;
  for (const Vec3& p : mesh.vertices) surface.add_vertex({p.x(), p.y(), p.z()});
  for (const auto& [a, b, c] : mesh.triangles)
    surface.add_face(Surface::Vertex_index(a), Surface::Vertex_index(b), Surface::Vertex_index(c));
  Tree tree(faces(surface).begin(), faces(surface).end(), surface);
  tree.accelerate_distance_queries();
  const CGAL::Side_of_triangle_mesh<Surface, Kernel> side(tree);
  std::vector<double> depths;
  for (const Vec3& p : points) {
    const Kernel::Point_3 at(p.x(), p.y(), p.z());
    const double distance = std::sqrt(tree.squared_distance(at));
    depths.push_back(side(at) == CGAL::ON_UNBOUNDED_SIDE ? -distance : distance);
  }
  return depths;
}

}  // namespace trackbed::geom
