// Points within the ground, observed wherever they lie.
#include <algorithm>
#include <cmath>
#include <limits>

#include "fem/ground/impl.hpp"
#include "fem/shape/tetrahedron.hpp"

namespace trackbed::fem {

namespace {

// In natural coordinates: a place on the border of an element may lie outside by rounding.
constexpr double on_border = 1e-9;

// A place in the natural coordinates of an element and how far it lies outside of it in them; at
// most 0 within.
struct Natural {
  Vec3 xi;
  double outside;
};

// Of a brick, from -1 to 1; in a plane the middle of the thickness.
Natural in_brick(const Mesh& mesh, std::size_t element, const Vec3& place) {
  const Id id = mesh.element[element];
  Vec3 xi = 2 * (place - mesh.lattice.centre(id)).cwiseQuotient(mesh.lattice.size_of(id));
  if (mesh.lattice.plane) xi.y() = 0;
  return {xi, xi.cwiseAbs().maxCoeff() - 1};
}

// Volume coordinates. Edges may be curved, so Newton's method is needed; it converges in one
// iteration if they are straight. A place far outside is not solved for.
Natural in_tetrahedron(const Mesh& mesh, std::size_t element, const Vec3& place) {
  TenNodes nodes;
  Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (int k = 0; k < 10; ++k) {
    const Vec3 node = mesh.position(mesh.corner(element, k));
    nodes[static_cast<std::size_t>(k)] = node;
    low = low.cwiseMin(node), high = high.cwiseMax(node);
  }
  const Vec3 margin = 0.1 * (high - low);  // a curved face may bulge beyond its nodes
  const Natural none{Vec3::Zero(), 1};
  if (((place - low + margin).array() < 0).any() || ((high + margin - place).array() < 0).any())
    return none;
  Vec3 xi = tetrahedron_centre();
  constexpr int most = 20;
  for (int iteration = 0; iteration < most; ++iteration) {
    const TenNumbers shape = tetrahedron_shape(xi);
    Vec3 at = Vec3::Zero();
    for (int k = 0; k < 10; ++k) at += shape[k] * nodes[static_cast<std::size_t>(k)];
    const Vec3 step = tetrahedron_jacobian(nodes, xi).partialPivLu().solve(place - at);
    xi += step;
    if (!xi.allFinite()) return none;
    if (step.cwiseAbs().maxCoeff() < 1e-12)  // far below on_border
      return {xi, -std::min({xi.minCoeff(), 1 - xi.sum()})};
  }
  return none;
}

Natural natural_of(const Mesh& mesh, std::size_t element, const Vec3& place) {
  return mesh.imported ? in_tetrahedron(mesh, element, place) : in_brick(mesh, element, place);
}

// Shape functions of the corners of an element.
std::vector<double> shape_at(const Mesh& mesh, const Vec3& xi) {
  if (mesh.imported) {
    const TenNumbers shape = tetrahedron_shape(xi);
    return {shape.begin(), shape.end()};
  }
  const bool plane = mesh.lattice.plane;
  std::vector<double> shape;
  for (int k = 0; k < mesh.lattice.corners(); ++k) {
    const auto side = [&](int bit, double x) { return (k >> bit & 1) != 0 ? 1 + x : 1 - x; };
    const double along = side(0, xi.x()), up = side(plane ? 1 : 2, xi.z());
    shape.push_back(plane ? along * up / 4 : along * side(1, xi.y()) * up / 8);
  }
  return shape;
}

constexpr std::size_t motion_numbers = 9;   // displacement, velocity, acceleration
constexpr std::size_t stress_numbers = 12;  // since static equilibrium, and in it

}  // namespace

// Of several elements that share a border the one with the lowest number is taken, so that the
// choice does not depend on ranks.
std::vector<GroundPoint> Ground::locate(std::span<const Vec3> places) const {
  const Mesh& mesh = impl_->mesh;
  constexpr double none = std::numeric_limits<double>::infinity();
  std::vector<GroundPoint> points;
  for (const Vec3& place : places) {
    double lowest = none;
    Vec3 xi = Vec3::Zero();
    for (std::size_t z = 0; z < mesh.element.size() && lowest == none; ++z) {
      const Natural natural = natural_of(mesh, z, place);
      if (natural.outside > on_border) continue;
      lowest = static_cast<double>(mesh.element[z]), xi = natural.xi;
    }
    // Ranks that hold the same element have computed the same coordinates.
    const double found = mesh.comm.min(lowest);
    std::array<double, 3> shared;
    for (int a = 0; a < 3; ++a)
      shared[static_cast<std::size_t>(a)] = lowest == found && found < none ? xi[a] : -none;
    mesh.comm.max(std::span<double>(shared));
    if (found < none)
      points.push_back({static_cast<Id>(found), Vec3(shared[0], shared[1], shared[2])});
    else
      points.push_back({});
  }
  return points;
}

// Each nodal value comes from the owner of the node and each stress from the rank that writes the
// element; the others add zero, so the sums are exact.
std::vector<GroundPointState> Ground::states_at(std::span<const GroundPoint> points) const {
  const Impl& impl = *impl_;
  const Mesh& mesh = impl.mesh;
  const auto corners = static_cast<std::size_t>(mesh.corners());
  const std::size_t numbers = corners * motion_numbers + stress_numbers;
  std::vector<double> values(points.size() * numbers, 0.0);
  for (std::size_t p = 0; p < points.size(); ++p) {
    const std::int64_t held = mesh.local_element(points[p].element);
    if (held < 0) continue;
    const auto element = static_cast<std::size_t>(held);
    double* to = &values[p * numbers];
    for (std::size_t k = 0; k < corners; ++k, to += motion_numbers) {
      const std::int32_t node = mesh.home(mesh.corner(element, static_cast<int>(k)));
      if (mesh.owned[static_cast<std::size_t>(node)] == 0) continue;
      double* at = to;
      for (const Nodal* of :
           {&impl.state.displacement, &impl.state.velocity, &impl.state.acceleration})
        for (const double number : impl.vector(*of, node)) *at++ = number;
    }
    if (!mesh.writes(element)) continue;
    for (const Plasticity::When when : {Plasticity::When::since, Plasticity::When::static_}) {
      const Vec6 stress = impl.stress(element, Plasticity::Where::centre, when);
      constexpr std::array order{0, 1, 2, 3, 5, 4};  // xy yz zx to xy xz yz
      for (const int component : order)
        *to++ = stress[component] + 0.0;  // no -0, which sums have not
    }
  }
  mesh.comm.sum(std::span(values));
  std::vector<GroundPointState> states;
  for (std::size_t p = 0; p < points.size(); ++p) {
    GroundPointState state;
    const double* from = &values[p * numbers];
    for (const double weight : shape_at(mesh, points[p].xi))
      for (Vec3* motion : {&state.displacement, &state.velocity, &state.acceleration}) {
        *motion += weight * Vec3(from[0], from[1], from[2]);
        from += 3;
      }
    std::copy_n(from, 6, state.stress.begin());
    std::copy_n(from + 6, 6, state.stress_static.begin());
    states.push_back(state);
  }
  return states;
}

}  // namespace trackbed::fem
