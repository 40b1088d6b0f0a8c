// Index arithmetic of a box of elements, based on the lattice of the ground.
#include "fem/bodies/body_mesh.hpp"

#include <algorithm>
#include <cmath>

namespace trackbed::fem {

namespace {

Lattice lattice_of(const Body& body) {
  Lattice lattice;
  lattice.elements = body.elements;
  lattice.low = body.low;
  for (int a = 0; a < 3; ++a)
    lattice.size[a] = (body.high[a] - body.low[a]) /
                      static_cast<double>(body.elements[static_cast<std::size_t>(a)]);
  return lattice;
}

Corners corners_of(const Vec3& size) {
  Corners corners;
  for (int k = 0; k < 8; ++k)
    for (int a = 0; a < 3; ++a)
      corners[static_cast<std::size_t>(k)][a] = (k >> a & 1) != 0 ? size[a] / 2 : -size[a] / 2;
  return corners;
}

// The interval, out of `cells` equal ones, that contains a distance from their begin, and the
// relative position in it, 0 to 1; the first or last interval for distances outside.
struct Cell {
  std::int64_t number;
  double fraction;
};
Cell cell_of(double distance, double size, std::int64_t cells) {
  const double turns = distance / size;
  const auto number =
      std::clamp(static_cast<std::int64_t>(std::floor(turns)), std::int64_t{0}, cells - 1);
  return {number, std::clamp(turns - static_cast<double>(number), 0.0, 1.0)};
}

}  // namespace

BodyMesh::BodyMesh(const Body& given, std::int32_t first_node)
    : body(given),
      first(first_node),
      lattice(lattice_of(given)),
      hexahedron(corners_of(lattice.size), elasticity(given.solid)) {}

std::array<std::int32_t, 8> BodyMesh::corners(std::int64_t element) const {
  std::array<std::int32_t, 8> nodes{};
  const Index3 at = lattice.element_index(element);
  for (int k = 0; k < 8; ++k)
    nodes[static_cast<std::size_t>(k)] = first + static_cast<std::int32_t>(lattice.corner(at, k));
  return nodes;
}

Vec3 BodyMesh::position(std::int32_t node) const {
  const Index3 point = lattice.node_index(node - first);
  Vec3 x;
  for (int a = 0; a < 3; ++a)
    x[a] = body.low[a] + static_cast<double>(point[static_cast<std::size_t>(a)]) * lattice.size[a];
  return x;
}

Vec3 BodyMesh::inertia() const {
  const Vec3 square = (body.high - body.low).cwiseAbs2();
  return mass() / 12 *
         Vec3(square.y() + square.z(), square.z() + square.x(), square.x() + square.y());
}

std::vector<std::int32_t> BodyMesh::face(int axis, bool low) const {
  const Index3 n = lattice.points();
  const auto a = static_cast<std::size_t>(axis);
  std::vector<std::int32_t> nodes;
  for (std::int32_t k = 0; k < this->nodes(); ++k)
    if (lattice.node_index(k)[a] == (low ? 0 : n[a] - 1)) nodes.push_back(first + k);
  return nodes;
}

NodeWeights BodyMesh::at(Side side, double x, double y) const {
  const Cell i = cell_of(x - body.low.x(), lattice.size.x(), body.elements[0]);
  const Cell j = cell_of(y - body.low.y(), lattice.size.y(), body.elements[1]);
  const std::int64_t k = side == Side::upper ? body.elements[2] : 0;
  NodeWeights weights;
  for (int b = 0; b < 2; ++b)
    for (int a = 0; a < 2; ++a)
      weights.push_back(
          {node({i.number + a, j.number + b, k}),
           (a == 1 ? i.fraction : 1 - i.fraction) * (b == 1 ? j.fraction : 1 - j.fraction)});
  return weights;
}

// Two by two Gauss points in each quarter. They have equal weight, so force and moment about the
// middle are exact, and so is the rotational stiffness of a pad, with the second moment L^2/12 of a
// side L; more points would only smooth below the resolution of the elements.
std::vector<std::array<double, 2>> BodyMesh::points(const Patch& patch) {
  const double off = std::sqrt(1.0 / 3) / 4;
  const std::array<double, 4> shares = {0.25 - off, 0.25 + off, 0.75 - off, 0.75 + off};
  std::vector<std::array<double, 2>> points;
  for (const double j : shares)
    for (const double i : shares)
      points.push_back(
          {patch.x[0] + i * (patch.x[1] - patch.x[0]), patch.y[0] + j * (patch.y[1] - patch.y[0])});
  return points;
}

std::vector<BodyMesh::Place> BodyMesh::around(const Vec3& place) const {
  constexpr double rounding = 1e-9;
  std::array<std::vector<Cell>, 3> cells;
  for (int a = 0; a < 3; ++a) {
    const auto k = static_cast<std::size_t>(a);
    const Cell cell = cell_of(place[a] - body.low[a], lattice.size[a], body.elements[k]);
    if (cell.fraction < rounding && cell.number > 0) cells[k].push_back({cell.number - 1, 1});
    cells[k].push_back(cell);
    if (cell.fraction > 1 - rounding && cell.number + 1 < body.elements[k])
      cells[k].push_back({cell.number + 1, 0});
  }
  std::vector<Place> found;
  for (const Cell& z : cells[2])
    for (const Cell& y : cells[1])
      for (const Cell& x : cells[0])
        found.push_back({lattice.element({x.number, y.number, z.number}),
                         2 * Vec3(x.fraction, y.fraction, z.fraction) - Vec3::Ones()});
  return found;
}

// A product over the axes: 1/3 at the same end of an edge, 1/6 at the other.
double mass_fraction(int corner, int other) {
  double fraction = 1;
  for (int a = 0; a < 3; ++a) fraction *= (corner >> a & 1) == (other >> a & 1) ? 1.0 / 3 : 1.0 / 6;
  return fraction;
}

// Each face of the body in turn: quadrangles of nodes, all cut along the same diagonal.
Surface surface_of(const BodyMesh& mesh, std::vector<std::int32_t>& node_of) {
  Surface surface;
  surface.name = mesh.body.name;
  std::vector<std::int32_t> number(static_cast<std::size_t>(mesh.nodes()), -1);
  const auto known = [&](const Index3& point) {
    const std::int32_t node = mesh.node(point);
    std::int32_t& of = number[static_cast<std::size_t>(node - mesh.first)];
    if (of < 0) {
      of = static_cast<std::int32_t>(node_of.size());
      node_of.push_back(node);
    }
    return of;
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const bool high : {false, true}) {
      // u, v, axis are right-handed: u x v points along the axis.
      const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
      const std::int64_t end = high ? mesh.body.elements[axis] : 0;
      for (std::int64_t j = 0; j < mesh.body.elements[v]; ++j)
        for (std::int64_t i = 0; i < mesh.body.elements[u]; ++i) {
          const auto corner = [&](int a, int b) {
            Index3 point{};
            point[axis] = end, point[u] = i + a, point[v] = j + b;
            return known(point);
          };
          const std::int32_t p = corner(0, 0), q = corner(1, 0), r = corner(1, 1), s = corner(0, 1);
          surface.triangles.push_back(high ? std::array{p, q, r} : std::array{p, r, q});
          surface.triangles.push_back(high ? std::array{p, r, s} : std::array{p, s, r});
        }
    }
  surface.position.assign(node_of.size(), Vec3::Zero());
  surface.motion.assign(node_of.size(), Vec3::Zero());
  surface.clear_load();
  return surface;
}

}  // namespace trackbed::fem
