// Shape functions N_k = l_k (2 l_k - 1) at corners and 4 l_i l_j at mid-edge, with l the volume
// coordinates of the four corners; and their integrals.
#include "fem/shape/tetrahedron.hpp"

#include <cmath>

namespace trackbed::fem {

namespace {

constexpr double near = 0.58541019662496845446, far = 0.13819660112501051518;

Eigen::Vector4d coordinates(const Vec3& xi) { return {1 - xi.sum(), xi.x(), xi.y(), xi.z()}; }

// Row k: d l_k / d xi.
Eigen::Matrix<double, 4, 3> coordinate_gradients() {
  Eigen::Matrix<double, 4, 3> g;
  g << -1, -1, -1, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  return g;
}

}  // namespace

// (5 + 3 sqrt 5)/20 for one corner, (5 - sqrt 5)/20 for the others: exact for polynomials of degree
// 2.
Vec3 tetrahedron_point(int gauss) {
  Vec3 xi = Vec3::Constant(far);
  if (gauss > 0) xi[gauss - 1] = near;
  return xi;
}

const Vec3& tetrahedron_centre() {
  static const Vec3 centre = Vec3::Constant(0.25);
  return centre;
}

Vec3 tetrahedron_face_centre(int face) {
  Eigen::Vector4d l = Eigen::Vector4d::Zero();
  for (int k = 0; k < 3; ++k)
    l[tetrahedron_faces[static_cast<std::size_t>(face)][static_cast<std::size_t>(k)]] = 1.0 / 3;
  return l.tail<3>();
}

TenNumbers tetrahedron_shape(const Vec3& xi) {
  const Eigen::Vector4d l = coordinates(xi);
  TenNumbers n;
  for (int k = 0; k < 4; ++k) n[k] = l[k] * (2 * l[k] - 1);
  for (int e = 0; e < 6; ++e) {
    const auto [i, j] = tetrahedron_edges[static_cast<std::size_t>(e)];
    n[4 + e] = 4 * l[i] * l[j];
  }
  return n;
}

Eigen::Matrix<double, 10, 3> tetrahedron_gradients(const Vec3& xi) {
  const Eigen::Vector4d l = coordinates(xi);
  const Eigen::Matrix<double, 4, 3> g = coordinate_gradients();
  Eigen::Matrix<double, 10, 3> n;
  for (int k = 0; k < 4; ++k) n.row(k) = (4 * l[k] - 1) * g.row(k);
  for (int e = 0; e < 6; ++e) {
    const auto [i, j] = tetrahedron_edges[static_cast<std::size_t>(e)];
    n.row(4 + e) = 4 * (l[i] * g.row(j) + l[j] * g.row(i));
  }
  return n;
}

Mat3 tetrahedron_jacobian(const TenNodes& nodes, const Vec3& xi) {
  const Eigen::Matrix<double, 10, 3> g = tetrahedron_gradients(xi);
  Mat3 j = Mat3::Zero();
  for (int k = 0; k < 10; ++k) j += nodes[static_cast<std::size_t>(k)] * g.row(k);
  return j;
}

// The coordinate of a Gauss point is `near` at its own corner and `far` at the others.
Eigen::Vector4d tetrahedron_weights(const Vec3& xi) {
  return (coordinates(xi).array() - far) / (near - far);
}

double tetrahedron_volume(const TenNodes& nodes) { return tetrahedron_load(nodes).sum(); }

double tetrahedron_mean_ratio(const TenNodes& nodes) {
  double squares = 0;
  for (const auto& [i, j] : tetrahedron_edges)
    squares +=
        (nodes[static_cast<std::size_t>(i)] - nodes[static_cast<std::size_t>(j)]).squaredNorm();
  const double volume =
      (nodes[1] - nodes[0]).cross(nodes[2] - nodes[0]).dot(nodes[3] - nodes[0]) / 6;
  return 12 * std::pow(3 * std::abs(volume), 2.0 / 3) / squares;
}

TenNumbers tetrahedron_load(const TenNodes& nodes) {
  TenNumbers load = TenNumbers::Zero();
  for (int g = 0; g < tetrahedron_points; ++g) {
    const Vec3 xi = tetrahedron_point(g);
    load +=
        tetrahedron_weight * tetrahedron_jacobian(nodes, xi).determinant() * tetrahedron_shape(xi);
  }
  return load;
}

// The diagonal of the consistent mass has the ratio 6 to 32; 4 x 6 + 6 x 32 = 216.
double tetrahedron_mass_fraction(int node) { return node < 4 ? 6.0 / 216 : 32.0 / 216; }

}  // namespace trackbed::fem
