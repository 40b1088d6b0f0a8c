// Per Gauss point: gradient of u by xi, by x, stress, and the transposed operations:
//   G = (sum_n u_n dN_n) J^-1,   sigma = lame tr(G) I + shear (G + G^T),
//   f_n += (sigma J^-T) dN_n V.
#include "fem/kernel/tetrahedra.hpp"

#include <algorithm>

namespace trackbed::fem {

namespace {

constexpr auto wide = static_cast<std::size_t>(lanes);

// Gradients of the shape functions by xi: the same for all elements.
struct Gradients {
  double of[4][10][3];
  Gradients() {
    for (int g = 0; g < tetrahedron_points; ++g) {
      const auto n = tetrahedron_gradients(tetrahedron_point(g));
      for (int k = 0; k < 10; ++k)
        for (int a = 0; a < 3; ++a) of[g][k][a] = n(k, a);
    }
  }
};
const Gradients& gradients() {
  static const Gradients all;
  return all;
}

// Stress from a displacement gradient, times a volume, transformed to xi.
inline void to_force(const Lane (&g)[3][3], const Lane& lame, const Lane& shear,
                     const Lane (&inverse)[3][3], Lane (&p)[3][3]) {
  const Lane pressure = lame * (g[0][0] + g[1][1] + g[2][2]);
  for (int c = 0; c < 3; ++c) {
    Lane s[3];
    for (int j = 0; j < 3; ++j) s[j] = shear * (g[c][j] + g[j][c]);
    s[c] += pressure;
    for (int a = 0; a < 3; ++a)
      p[c][a] = s[0] * inverse[a][0] + s[1] * inverse[a][1] + s[2] * inverse[a][2];
  }
}

}  // namespace

Tetrahedra::Tetrahedra(const Mesh& mesh, double common_damping) : mesh_(mesh) {
  const std::size_t count = mesh.element.size();
  groups_.assign((count + wide - 1) / wide, Group{});
  for (std::size_t e = 0; e < count; ++e) fill(e, groups_[e / wide], e % wide, common_damping);
  for (const Elastic& solid : mesh.solids.solid)
    damps_ = damps_ || solid.rayleigh_stiffness != common_damping;
}

TenNodes Tetrahedra::nodes_of(std::size_t element) const {
  TenNodes nodes;
  for (std::size_t k = 0; k < 10; ++k)
    nodes[k] = mesh_.position(mesh_.corner(element, static_cast<int>(k)));
  return nodes;
}

void Tetrahedra::fill(std::size_t element, Group& group, std::size_t lane,
                      double common_damping) const {
  const Elastic& solid = mesh_.solids.solid[static_cast<std::size_t>(mesh_.solid[element])];
  const TenNodes nodes = nodes_of(element);
  for (int g = 0; g < tetrahedron_points; ++g) {
    const Mat3 j = tetrahedron_jacobian(nodes, tetrahedron_point(g)), inverse = j.inverse();
    group.volume[g][lane] = tetrahedron_weight * j.determinant();
    for (int a = 0; a < 3; ++a)
      for (int i = 0; i < 3; ++i) group.inverse[g][a][i][lane] = inverse(a, i);
  }
  const Lame lame = lame_of(solid);
  group.lame[lane] = lame.lame, group.shear[lane] = lame.shear;
  group.damps[lane] = solid.rayleigh_stiffness - common_damping;
}

void Tetrahedra::run(const Nodal& u, Nodal& f, bool damping) const {
  const Gradients& by_xi = gradients();
  const std::size_t count = mesh_.element.size();
  for (std::size_t first = 0; first < count; first += wide) {
    const Group& group = groups_[first / wide];
    const std::size_t real = std::min(wide, count - first);
    Lane from[3][10] = {}, to[3][10] = {};
    for (std::size_t lane = 0; lane < real; ++lane)
      for (int k = 0; k < 10; ++k) {
        const std::int32_t node = mesh_.corner(first + lane, k);
        for (int c = 0; c < 3; ++c) from[c][k][lane] = u[c][node];
      }
    for (int g = 0; g < tetrahedron_points; ++g) {
      const auto& n = by_xi.of[g];
      const auto& inverse = group.inverse[g];
      Lane gradient[3][3], force[3][3];
      for (int c = 0; c < 3; ++c) {
        Lane h[3] = {};
        for (int k = 0; k < 10; ++k)
          for (int a = 0; a < 3; ++a) h[a] += n[k][a] * from[c][k];
        for (int j = 0; j < 3; ++j)
          gradient[c][j] = h[0] * inverse[0][j] + h[1] * inverse[1][j] + h[2] * inverse[2][j];
      }
      const Lane factor = damping ? group.damps * group.volume[g] : group.volume[g];
      to_force(gradient, factor * group.lame, factor * group.shear, inverse, force);
      for (int c = 0; c < 3; ++c)
        for (int k = 0; k < 10; ++k)
          to[c][k] += n[k][0] * force[c][0] + n[k][1] * force[c][1] + n[k][2] * force[c][2];
    }
    for (std::size_t lane = 0; lane < real; ++lane)
      for (int k = 0; k < 10; ++k) {
        const std::int32_t node = mesh_.corner(first + lane, k);
        for (int c = 0; c < 3; ++c) f[c][node] += to[c][k][lane];
      }
  }
}

//   K_(kc)(ld) = sum V [lame N_k,c N_l,d + shear (N_k,d N_l,c + delta_cd N_k . N_l)]
Eigen::MatrixXd Tetrahedra::matrix(std::size_t element) const {
  const Elastic& solid = mesh_.solids.solid[static_cast<std::size_t>(mesh_.solid[element])];
  const Lame lame = lame_of(solid);
  const TenNodes nodes = nodes_of(element);
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(30, 30);
  for (int g = 0; g < tetrahedron_points; ++g) {
    const Vec3 xi = tetrahedron_point(g);
    const Mat3 j = tetrahedron_jacobian(nodes, xi);
    const double volume = tetrahedron_weight * j.determinant();
    const Eigen::Matrix<double, 10, 3> n = tetrahedron_gradients(xi) * j.inverse();
    for (int a = 0; a < 10; ++a)
      for (int b = 0; b < 10; ++b) {
        const Vec3 left = n.row(a), right = n.row(b);
        Mat3 block = lame.lame * left * right.transpose() + lame.shear * right * left.transpose();
        block.diagonal().array() += lame.shear * left.dot(right);
        k.block<3, 3>(3 * a, 3 * b) += volume * block;
      }
  }
  return k;
}

Vec6 Tetrahedra::stress(std::size_t element, const Vec3& xi, const Nodal& u) const {
  const Elastic& solid = mesh_.solids.solid[static_cast<std::size_t>(mesh_.solid[element])];
  const Lame lame = lame_of(solid);
  const Eigen::Matrix<double, 10, 3> n =
      tetrahedron_gradients(xi) * tetrahedron_jacobian(nodes_of(element), xi).inverse();
  Mat3 gradient = Mat3::Zero();
  for (int k = 0; k < 10; ++k) {
    const std::int32_t node = mesh_.corner(element, k);
    gradient += Vec3(u[0][node], u[1][node], u[2][node]) * n.row(k);
  }
  Mat3 s = lame.shear * (gradient + gradient.transpose());
  s.diagonal().array() += lame.lame * gradient.trace();
  Vec6 stress;
  stress << s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(2, 0);
  return stress;
}

}  // namespace trackbed::fem
