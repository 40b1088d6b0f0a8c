// Gauss points of tetrahedra one by one, for yielding solids.
#include "fem/kernel/tetrahedra.hpp"

namespace trackbed::fem {

namespace {

// Components of a symmetric tensor in Voigt's order.
constexpr int place[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};

using ByXi = Eigen::Matrix<double, 10, 3>;
const std::array<ByXi, tetrahedron_points>& point_gradients() {
  static const auto all = [] {
    std::array<ByXi, tetrahedron_points> made;
    for (int g = 0; g < tetrahedron_points; ++g)
      made[static_cast<std::size_t>(g)] = tetrahedron_gradients(tetrahedron_point(g));
    return made;
  }();
  return all;
}

}  // namespace

// Lanes beyond the last element have zero volume and zero stress.
void Tetrahedra::stress(std::size_t number, const Nodal& u0, const Nodal& u, Points& stress) const {
  const Group& group = groups_[number];
  const std::size_t first = number * lanes, count = mesh_.element.size();
  Lane from[3][10] = {};
  for (std::size_t lane = 0; lane < lanes && first + lane < count; ++lane)
    for (int k = 0; k < 10; ++k) {
      const std::int32_t node = mesh_.corner(first + lane, k);
      for (int c = 0; c < 3; ++c) from[c][k][lane] = u0[c][node] + u[c][node];
    }
  for (int g = 0; g < tetrahedron_points; ++g) {
    const ByXi& n = point_gradients()[static_cast<std::size_t>(g)];
    Lane by[3][3];  // du_c / dx_j
    for (int c = 0; c < 3; ++c) {
      Lane h[3] = {};
      for (int k = 0; k < 10; ++k)
        for (int a = 0; a < 3; ++a) h[a] += n(k, a) * from[c][k];
      for (int j = 0; j < 3; ++j)
        by[c][j] = h[0] * group.inverse[g][0][j] + h[1] * group.inverse[g][1][j] +
                   h[2] * group.inverse[g][2][j];
    }
    const Lane pressure = group.lame * (by[0][0] + by[1][1] + by[2][2]);
    for (int c = 0; c < 3; ++c)
      for (int j = c; j < 3; ++j)
        stress[place[c][j]][g] = group.shear * (by[c][j] + by[j][c]) + (c == j ? pressure : Lane{});
  }
}

void Tetrahedra::hooke(std::size_t number, const Points& strain, Points& stress) const {
  const Group& group = groups_[number];
  for (int g = 0; g < tetrahedron_points; ++g) {
    const Lane pressure = group.lame * (strain[0][g] + strain[1][g] + strain[2][g]);
    for (int c = 0; c < 3; ++c) stress[c][g] = pressure + 2 * group.shear * strain[c][g];
    for (int c = 3; c < 6; ++c) stress[c][g] = group.shear * strain[c][g];
  }
}

void Tetrahedra::take_off(std::size_t number, const Points& stress,
                          const std::uint8_t (&marked)[lanes], Nodal& f) const {
  const Group& group = groups_[number];
  Lane to[3][10] = {};
  for (int g = 0; g < tetrahedron_points; ++g) {
    const ByXi& n = point_gradients()[static_cast<std::size_t>(g)];
    for (int c = 0; c < 3; ++c) {
      Lane by_xi[3];
      for (int a = 0; a < 3; ++a)
        by_xi[a] = group.volume[g] * (stress[place[c][0]][g] * group.inverse[g][a][0] +
                                      stress[place[c][1]][g] * group.inverse[g][a][1] +
                                      stress[place[c][2]][g] * group.inverse[g][a][2]);
      for (int k = 0; k < 10; ++k)
        to[c][k] += n(k, 0) * by_xi[0] + n(k, 1) * by_xi[1] + n(k, 2) * by_xi[2];
    }
  }
  for (std::size_t lane = 0; lane < lanes; ++lane)
    for (int k = 0; marked[lane] != 0 && k < 10; ++k) {
      const std::int32_t node = mesh_.corner(number * lanes + lane, k);
      for (int c = 0; c < 3; ++c) f[c][node] -= to[c][k][lane];
    }
}

// As matrices, for the tangent and for energies.
ElementPoints Tetrahedra::points(std::size_t element) const {
  const Voigt d = elasticity(mesh_.solids.solid[static_cast<std::size_t>(mesh_.solid[element])]);
  const TenNodes nodes = nodes_of(element);
  ElementPoints found;
  found.volume.resize(tetrahedron_points);
  found.recovery = Eigen::MatrixXd::Zero(6 * tetrahedron_points, 30);
  found.relief = Eigen::MatrixXd::Zero(6 * tetrahedron_points, 6 * tetrahedron_points);
  for (int g = 0; g < tetrahedron_points; ++g) {
    const Mat3 j = tetrahedron_jacobian(nodes, tetrahedron_point(g));
    const ByXi n = point_gradients()[static_cast<std::size_t>(g)] * j.inverse();
    found.volume[g] = tetrahedron_weight * j.determinant();
    Eigen::Matrix<double, 6, 30> strain = Eigen::Matrix<double, 6, 30>::Zero();
    for (int k = 0; k < 10; ++k)
      for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b) strain(place[a][b], 3 * k + a) += n(k, b);
    found.recovery.middleRows<6>(6 * g) = d * strain;
    found.relief.block<6, 6>(6 * g, 6 * g) = -d;
  }
  return found;
}

}  // namespace trackbed::fem
