// Each check is a function that adds its messages; problems that follow from others are not
// searched for. One message per kind, with its first location and the number of others.
#include "fem/mesh/solid_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "fem/mesh/embankment.hpp"
#include "fem/mesh/mesh_problems.hpp"
#include "fem/shape/tetrahedron.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::fem {

namespace {

using Nodes3 = std::array<std::int32_t, 3>;

// A face of an element by its corners, sorted.
struct Side {
  Nodes3 corners;
  std::int32_t element, side;
  bool operator<(const Side& other) const {
    return corners != other.corners ? corners < other.corners : element < other.element;
  }
};

Nodes3 sorted(Nodes3 corners) {
  std::sort(corners.begin(), corners.end());
  return corners;
}

class Builder {
 public:
  Builder(const GroundParameters& parameters, GmshFile file)
      : parameters_(parameters), file_(std::move(file)), problems_(file_) {}
  SolidMesh build();

 private:
  void take_elements();
  void check_shapes();
  void check_nodes();
  void check_edges();
  void list_sides();
  void check_parts();
  void take_faces();
  void take_open(const std::vector<char>& taken);
  void take_face(const GmshFile::Element& triangle, const Side& side);
  bool fits(const GmshFile::Element& triangle, const SolidMesh::Face& face) const;
  void turn_of(SolidMesh::Face& face) const;
  void check_direction(const GmshFile::Element& triangle, const SolidMesh::Face& face, int border);
  void flatten_top();
  TenNodes places(std::size_t element) const;
  double extent() const { return (high_ - low_).norm(); }

  const GroundParameters& parameters_;
  GmshFile file_;
  MeshProblems problems_;
  SolidMesh mesh_;
  Vec3 low_, high_;
  std::vector<Side> sides_;  // of all elements, sorted
};

void Builder::take_elements() {
  constexpr double huge = std::numeric_limits<double>::infinity();
  low_.setConstant(huge), high_.setConstant(-huge);
  for (const GmshFile::Node& node : file_.nodes) {
    mesh_.position.push_back(node.at);
    low_ = low_.cwiseMin(node.at), high_ = high_.cwiseMax(node.at);
  }
  for (const GmshFile::Element& element : file_.tetrahedra) {
    mesh_.element.push_back(element.nodes);
    mesh_.solid.push_back(problems_.solid_of(element, parameters_));
  }
}

TenNodes Builder::places(std::size_t element) const {
  TenNodes nodes;
  for (std::size_t k = 0; k < 10; ++k)
    nodes[k] = mesh_.position[static_cast<std::size_t>(mesh_.element[element][k])];
  return nodes;
}

// At the Gauss points, on which the integrals depend, and at all nodes, where a curved edge folds
// the element first.
void Builder::check_shapes() {
  static const std::array<Vec3, 10> at_nodes = [] {
    std::array<Vec3, 10> xi;
    xi.fill(Vec3::Zero());
    for (int k = 1; k < 4; ++k) xi[static_cast<std::size_t>(k)][k - 1] = 1;
    for (std::size_t middle = 4; const auto& [i, j] : tetrahedron_edges)
      xi[middle++] = 0.5 * (xi[static_cast<std::size_t>(i)] + xi[static_cast<std::size_t>(j)]);
    return xi;
  }();
  for (std::size_t e = 0; e < mesh_.element.size(); ++e) {
    const TenNodes nodes = places(e);
    double size = 0;
    for (std::size_t k = 1; k < 4; ++k) size = std::max(size, (nodes[k] - nodes[0]).norm());
    double least = std::numeric_limits<double>::infinity();
    const auto look = [&](const Vec3& xi) {
      least = std::min(least, tetrahedron_jacobian(nodes, xi).determinant());
    };
    for (int g = 0; g < tetrahedron_points; ++g) look(tetrahedron_point(g));
    for (const Vec3& xi : at_nodes) look(xi);
    // Flatter elements consist of rounding error only.
    if (!(least > 1e-12 * size * size * size))
      problems_.add("shape", file_.tetrahedra[e],
                    fmt::format("is inverted or flat: its smallest Jacobian is {:.3g} m^3", least));
    else if (const double ratio = tetrahedron_mean_ratio(nodes); !(ratio >= least_mean_ratio))
      problems_.add("flat", file_.tetrahedra[e],
                    fmt::format("is flat: its shape quality (mean ratio, 1: equilateral) is {:.2g} "
                                "and must be at least {:g}",
                                ratio, least_mean_ratio));
  }
}

// Two nodes at the same position are a gap: an apparently continuous solid is not connected there.
// Sorted along a direction with which no mesh is aligned, so that few pairs are compared.
void Builder::check_nodes() {
  std::vector<char> used(mesh_.position.size(), 0);
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t e = 0; e < mesh_.element.size(); ++e) {
    for (const std::int32_t n : mesh_.element[e]) used[static_cast<std::size_t>(n)] = 1;
    const TenNodes nodes = places(e);
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < a; ++b)
        shortest = std::min(shortest, (nodes[a] - nodes[b]).norm());
  }
  for (std::size_t n = 0; n < used.size(); ++n)
    if (used[n] == 0)
      problems_.add("free", file_.nodes[n],
                    "is in no tetrahedron, so that nothing holds it (in Gmsh: save elements of "
                    "physical groups only)");
  const Vec3 along = Vec3(0.5773, 0.6180, 0.5342).normalized();
  std::vector<std::pair<double, std::int32_t>> order;
  for (std::size_t n = 0; n < used.size(); ++n)
    order.emplace_back(along.dot(mesh_.position[n]), static_cast<std::int32_t>(n));
  std::sort(order.begin(), order.end());
  const double same = 1e-3 * shortest;
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t j = i + 1; j < order.size() && order[j].first - order[i].first < same; ++j) {
      const auto a = static_cast<std::size_t>(order[i].second);
      const auto b = static_cast<std::size_t>(order[j].second);
      if ((mesh_.position[a] - mesh_.position[b]).norm() < same)
        problems_.add("gap", file_.nodes[std::max(a, b)],
                      fmt::format("is at the position of node {}, but not connected with it: the "
                                  "ground has a gap there (in Gmsh: Coherence or BooleanFragments)",
                                  file_.nodes[std::min(a, b)].tag));
    }
}

// Elements that share an edge must share its mid-edge node.
void Builder::check_edges() {
  std::vector<std::pair<std::array<std::int32_t, 2>, std::array<std::int32_t, 2>>> edges;
  for (std::size_t e = 0; e < mesh_.element.size(); ++e)
    for (std::size_t k = 0; k < 6; ++k) {
      const auto& nodes = mesh_.element[e];
      const auto& [i, j] = tetrahedron_edges[k];
      const auto [low, high] =
          std::minmax({nodes[static_cast<std::size_t>(i)], nodes[static_cast<std::size_t>(j)]});
      edges.push_back({{low, high}, {nodes[4 + k], static_cast<std::int32_t>(e)}});
    }
  std::sort(edges.begin(), edges.end());
  for (std::size_t k = 1; k < edges.size(); ++k)
    if (edges[k].first == edges[k - 1].first && edges[k].second[0] != edges[k - 1].second[0])
      problems_.add(
          "edge", file_.tetrahedra[static_cast<std::size_t>(edges[k].second[1])],
          fmt::format("shares two corners with element {}, but not their mid-edge node",
                      file_.tetrahedra[static_cast<std::size_t>(edges[k - 1].second[1])].tag));
}

void Builder::list_sides() {
  for (std::size_t e = 0; e < mesh_.element.size(); ++e)
    for (std::size_t s = 0; s < 4; ++s) {
      Nodes3 corners;
      for (std::size_t k = 0; k < 3; ++k)
        corners[k] = mesh_.element[e][static_cast<std::size_t>(tetrahedron_faces[s][k])];
      sides_.push_back(
          {sorted(corners), static_cast<std::int32_t>(e), static_cast<std::int32_t>(s)});
    }
  std::sort(sides_.begin(), sides_.end());
  for (std::size_t k = 2; k < sides_.size(); ++k)
    if (sides_[k].corners == sides_[k - 2].corners)
      problems_.add("overlap", file_.tetrahedra[static_cast<std::size_t>(sides_[k].element)],
                    "has a face that two other elements share: elements overlap");
}

// Connectivity of elements by faces.
void Builder::check_parts() {
  std::vector<std::int32_t> root(mesh_.element.size());
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](std::int32_t e) {
    const auto up = [&](std::int32_t k) -> std::int32_t& {
      return root[static_cast<std::size_t>(k)];
    };
    while (up(e) != e) e = up(e) = up(up(e));
    return e;
  };
  for (std::size_t k = 1; k < sides_.size(); ++k)
    if (sides_[k].corners == sides_[k - 1].corners) {
      const auto [low, high] = std::minmax({find(sides_[k].element), find(sides_[k - 1].element)});
      root[static_cast<std::size_t>(high)] = low;
    }
  for (std::size_t e = 0; e < root.size(); ++e)
    if (find(static_cast<std::int32_t>(e)) != 0)
      problems_.add("part", file_.tetrahedra[e],
                    fmt::format("is not connected with element {} by faces: the ground consists of "
                                "several parts",
                                file_.tetrahedra[0].tag));
}

bool Builder::fits(const GmshFile::Element& triangle, const SolidMesh::Face& face) const {
  auto mine = mesh_.nodes_of(face);
  std::array<std::int32_t, 6> given{};
  std::copy_n(triangle.nodes.begin(), 6, given.begin());
  std::sort(mine.begin(), mine.end());
  std::sort(given.begin(), given.end());
  return mine == given;
}

// The normal must be the same at each node of the face; rounding of coordinates with some ten
// digits is allowed.
void Builder::turn_of(SolidMesh::Face& face) const {
  constexpr double even = 1e-6;
  const auto nodes = mesh_.nodes_of(face);
  const auto at = [&](std::size_t k) { return mesh_.position[static_cast<std::size_t>(nodes[k])]; };
  const Vec3 normal = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  bool flat = std::abs(std::abs(normal[axis]) - 1) < even * even;
  double size = 0;
  for (std::size_t k = 1; k < 3; ++k) size = std::max(size, (at(k) - at(0)).norm());
  for (std::size_t k = 1; k < 6; ++k)
    flat = flat && std::abs(at(k)[axis] - at(0)[axis]) < even * size;
  face.axis = flat ? static_cast<int>(axis) : -1;
  face.low = normal[axis] < 0;
}

void Builder::check_direction(const GmshFile::Element& triangle, const SolidMesh::Face& face,
                              int number) {
  if (number < 0) {
    if (face.axis != 2 || face.low)
      problems_.add(
          "top", triangle,
          "of the top is not level or does not face up: the top must be level and at z = 0");
    return;
  }
  const MeshBorder& border = parameters_.borders[static_cast<std::size_t>(number)];
  const bool even = border.holds == BorderKind::roller || border.holds == BorderKind::viscous;
  if (even && face.axis < 0)
    problems_.add("turn " + border.name, triangle,
                  fmt::format("of border \"{}\" is not normal to x, y or z, as rollers and "
                              "viscous borders must be; use fixed or free",
                              border.name));
}

void Builder::take_face(const GmshFile::Element& triangle, const Side& side) {
  const int border = problems_.border_of(triangle, parameters_);
  if (border == MeshProblems::nowhere) return;
  SolidMesh::Face face{side.element, side.side, BorderKind::free, -1, false};
  face.border = border;
  if (border >= 0) face.holds = parameters_.borders[static_cast<std::size_t>(border)].holds;
  if (!fits(triangle, face))
    return problems_.add("middle", triangle,
                         "is a triangle without the mid-edge nodes of its tetrahedron");
  turn_of(face);
  check_direction(triangle, face, border);
  (border < 0 ? mesh_.top : mesh_.borders).push_back(face);
}

// Boundary faces that no triangle of the file covers.
void Builder::take_open(const std::vector<char>& taken) {
  for (std::size_t k = 0; k < sides_.size(); ++k) {
    const auto same = [&](std::size_t other) {
      return other < sides_.size() && sides_[other].corners == sides_[k].corners;
    };
    if (taken[k] == 0 && !same(k + 1) && !same(k - 1))
      mesh_.open.push_back({sides_[k].element, sides_[k].side, BorderKind::free, -1, false});
  }
}

void Builder::take_faces() {
  std::vector<char> taken(sides_.size(), 0);
  for (const GmshFile::Element& triangle : file_.triangles) {
    const Nodes3 corners = sorted({triangle.nodes[0], triangle.nodes[1], triangle.nodes[2]});
    const auto first = std::lower_bound(
        sides_.begin(), sides_.end(), corners,
        [](const Side& side, const Nodes3& wanted) { return side.corners < wanted; });
    if (first == sides_.end() || first->corners != corners) {
      problems_.add("loose", triangle, "is a triangle, but not a face of a tetrahedron");
      continue;
    }
    if (first + 1 != sides_.end() && (first + 1)->corners == corners) {
      problems_.add("inside", triangle,
                    "is a triangle between two elements: borders and top must be on the boundary");
      continue;
    }
    char& again = taken[static_cast<std::size_t>(first - sides_.begin())];
    if (again != 0)
      problems_.add("twice", triangle, "is a triangle identical to an earlier one");
    else
      take_face(triangle, *first);
    again = 1;
  }
  take_open(taken);
  const auto order = [](const SolidMesh::Face& a, const SolidMesh::Face& b) {
    return a.element != b.element ? a.element < b.element : a.side < b.side;
  };
  std::sort(mesh_.borders.begin(), mesh_.borders.end(), order);
  std::sort(mesh_.top.begin(), mesh_.top.end(), order);
}

// Exactly z = 0, as for layers.
void Builder::flatten_top() {
  for (const SolidMesh::Face& face : mesh_.top)
    for (const std::int32_t n : mesh_.nodes_of(face)) {
      double& z = mesh_.position[static_cast<std::size_t>(n)].z();
      if (std::abs(z) > 1e-6 * extent())
        problems_.add("level", file_.nodes[static_cast<std::size_t>(n)],
                      fmt::format("of the top is at z = {:g} m: the top must be at z = 0", z));
      z = 0;
    }
}

// In three passes: elements, their connectivity, borders.
SolidMesh Builder::build() {
  problems_.check_groups(parameters_);
  take_elements();
  problems_.raise();
  check_shapes();
  check_nodes();
  check_edges();
  list_sides();
  check_parts();
  problems_.raise();
  take_faces();
  flatten_top();
  problems_.raise();
  return std::move(mesh_);
}

}  // namespace

std::array<std::int32_t, 6> SolidMesh::nodes_of(const Face& face) const {
  std::array<std::int32_t, 6> nodes{};
  const auto& of_element = element[static_cast<std::size_t>(face.element)];
  const auto& local = tetrahedron_faces[static_cast<std::size_t>(face.side)];
  for (std::size_t k = 0; k < 6; ++k) nodes[k] = of_element[static_cast<std::size_t>(local[k])];
  return nodes;
}

double SolidMesh::depth() const {
  double lowest = 0;
  for (const Vec3& at : position) lowest = std::min(lowest, at.z());
  return -lowest;
}

SolidMesh solid_mesh_of(const GroundParameters& parameters, GmshFile file) {
  return Builder(parameters, std::move(file)).build();
}

SolidMesh make_solid_mesh(const GroundParameters& parameters) {
  return parameters.sections.empty() ? read_solid_mesh(parameters) : embankment_mesh(parameters);
}

SolidMesh read_solid_mesh(const GroundParameters& parameters) {
  return solid_mesh_of(parameters, read_gmsh(parameters.mesh));
}

}  // namespace trackbed::fem
