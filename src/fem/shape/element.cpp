// Enhanced-strain hexahedron: integration, condensation, stress recovery, reduction to a plane.
//
// Everything here runs once per solid at the start, so clarity has priority: 6x24 strain matrices
// at eight points. Rejected: one-point quadrature with hourglass control (a parameter to tune and
// to justify), selective reduced integration (locks in bending), nodal pressure (couples elements,
// no lumped explicit step).
//
// Symbols: u corner displacements, m; alpha enhanced parameters; B and E strain matrices; D
// elasticity, Pa. Integrals are sums over 2x2x2 Gauss points with weight 1.
#include "fem/shape/element.hpp"

#include <cmath>

#include "trackbed/core/decompositions.hpp"

namespace trackbed::fem {

namespace {

// -1 or +1: side of the unit cube on which a corner is.
double sign_of(int corner, int axis) { return (corner >> axis & 1) != 0 ? 1.0 : -1.0; }

// Gradient of the shape function of a corner on the unit cube.
//   N_k = (1 + x_k xi)(1 + y_k eta)(1 + z_k zeta)/8,  x_k, y_k, z_k = -1 or +1.
Vec3 shape_gradient(int corner, const Vec3& xi) {
  Vec3 gradient;
  for (int a = 0; a < 3; ++a) {
    gradient[a] = 0.125 * sign_of(corner, a);
    for (int b = 0; b < 3; ++b)
      if (b != a) gradient[a] *= 1 + sign_of(corner, b) * xi[b];
  }
  return gradient;
}

// Symmetric tensor to strain in Voigt's order (shear doubled).
Eigen::Matrix<double, 6, 1> voigt(const Mat3& e) {
  Eigen::Matrix<double, 6, 1> v;
  v << e(0, 0), e(1, 1), e(2, 2), 2 * e(0, 1), 2 * e(1, 2), 2 * e(2, 0);
  return v;
}

// Two points per direction integrate the stiffness of a box exactly.
Vec3 gauss_point(int index) {
  const double g = 1 / std::sqrt(3.0);
  return {g * sign_of(index, 0), g * sign_of(index, 1), g * sign_of(index, 2)};
}

}  // namespace

Lame lame_of(const Elastic& s) {
  const double shear = s.young / (2 * (1 + s.poisson));
  return {s.young * s.poisson / ((1 + s.poisson) * (1 - 2 * s.poisson)), shear};
}

// Plane stress means sigma_y = 0 only: shear in y does not occur, as there is no motion along y.
Voigt elasticity(const Elastic& solid, bool sigma_y_free) {
  const auto [lame, shear] = lame_of(solid);
  Voigt d = Voigt::Zero();
  d.topLeftCorner<3, 3>().setConstant(lame);
  d.topLeftCorner<3, 3>().diagonal().array() += 2 * shear;
  d.bottomRightCorner<3, 3>().diagonal().setConstant(shear);
  if (!sigma_y_free) return d;
  // Static condensation of one row and column: the condensed matrix yields no sigma_y.
  const Eigen::Matrix<double, 6, 1> y = d.col(1);
  return d - y * y.transpose() / d(1, 1);
}

//   K_uu = int B^T D B dV,  Gamma = int E^T D B dV,  H = int E^T D E dV
Hexahedron::Hexahedron(const Corners& corners, const Voigt& elasticity)
    : corners_(corners), elasticity_(elasticity) {
  const Mat3 centre = jacobian(Vec3::Zero());
  centre_inverse_ = centre.inverse();
  centre_volume_ = centre.determinant();
  // Stationary in alpha: H alpha + Gamma u = 0, so K = K_uu - Gamma^T H^-1 Gamma.
  Eigen::Matrix<double, 12, 12> h = Eigen::Matrix<double, 12, 12>::Zero();
  Eigen::Matrix<double, 12, 24> gamma = Eigen::Matrix<double, 12, 24>::Zero();
  stiffness_.setZero();
  for (int g = 0; g < 8; ++g) {
    const Vec3 xi = gauss_point(g);
    const double volume = jacobian(xi).determinant();
    const auto b = compatible(xi);
    const auto e = enhanced(xi);
    stiffness_ += b.transpose() * elasticity_ * b * volume;
    gamma += e.transpose() * elasticity_ * b * volume;
    h += e.transpose() * elasticity_ * e * volume;
  }
  // A parameter without stiffness (sigma_y free) must remain zero: least-norm solution.
  alpha_ = -least_norm_solutions(h, gamma);
  stiffness_ += gamma.transpose() * alpha_;
  // Exactly symmetric, as solvers and the pattern form assume.
  stiffness_ = (0.5 * (stiffness_ + stiffness_.transpose())).eval();
}

// Constant for a box; general shapes are supported so that patch tests can use distorted elements.
Mat3 Hexahedron::jacobian(const Vec3& xi) const {
  Mat3 j = Mat3::Zero();  // d x_i / d xi_a
  for (int k = 0; k < 8; ++k)
    j += corners_[static_cast<std::size_t>(k)] * shape_gradient(k, xi).transpose();
  return j;
}

Eigen::Matrix<double, 6, 24> Hexahedron::compatible(const Vec3& xi) const {
  Eigen::Matrix<double, 6, 24> b = Eigen::Matrix<double, 6, 24>::Zero();
  const Mat3 inverse = jacobian(xi).inverse();
  for (int k = 0; k < 8; ++k) {
    const Vec3 g = inverse.transpose() * shape_gradient(k, xi);
    // Columns of u_x, u_y, u_z; rows xx yy zz xy yz zx.
    const int at = 3 * k;
    b(0, at) = b(3, at + 1) = b(5, at + 2) = g.x();
    b(1, at + 1) = b(3, at) = b(4, at + 2) = g.y();
    b(2, at + 2) = b(4, at + 1) = b(5, at) = g.z();
  }
  return b;
}

// Transformed with the Jacobian at the centre, not at the point: only then does a constant stress
// do no work on the enhanced strains (Taylor, Beresford, Wilson 1976).
Eigen::Matrix<double, 6, 12> Hexahedron::enhanced(const Vec3& xi) const {
  Eigen::Matrix<double, 6, 12> e;
  // This factor makes the integral of E over the element that of an odd function: zero.
  const double scale = centre_volume_ / jacobian(xi).determinant();
  int column = 0;
  // Incompatible mode (component a) * (1 - xi_b^2): covariant strain e_ab ~ xi_b.
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      Mat3 tensor = Mat3::Zero();
      tensor(a, b) += 0.5 * xi[b];
      tensor(b, a) += 0.5 * xi[b];
      e.col(column++) = scale * voigt(centre_inverse_.transpose() * tensor * centre_inverse_);
    }
  // Bilinear volumetric strains, which the modes above cannot cancel: without them three
  // bending-like corner patterns become too stiff as nu -> 1/2.
  for (int a = 0; a < 3; ++a)
    e.col(column++) = scale * xi[a] * xi[(a + 1) % 3] * voigt(Mat3::Identity());
  return e;
}

// Pa per m of displacement.
Eigen::Matrix<double, 6, 24> Hexahedron::stress(const Vec3& xi) const {
  return elasticity_ * (compatible(xi) + enhanced(xi) * alpha_);
}

// Plastic strain e is strain without stress: H alpha + Gamma u = int E^T D e dV. With the corners
// held sigma = D (E alpha - e); the part of e that E can represent is free of stress.
Eigen::MatrixXd Hexahedron::relief() const {
  Eigen::Matrix<double, 12, 12> h = Eigen::Matrix<double, 12, 12>::Zero();
  Eigen::MatrixXd e(48, 12), weighted(48, 12);  // E at all points; D E dV
  for (int g = 0; g < 8; ++g) {
    const Vec3 xi = gauss_point(g);
    const double volume = jacobian(xi).determinant();
    e.middleRows<6>(6 * g) = enhanced(xi);
    weighted.middleRows<6>(6 * g) = elasticity_ * enhanced(xi) * volume;
    h += enhanced(xi).transpose() * elasticity_ * enhanced(xi) * volume;
  }
  Eigen::MatrixXd strain = e * least_norm_solutions(h, weighted.transpose());
  strain -= Eigen::MatrixXd::Identity(48, 48);
  for (int g = 0; g < 8; ++g)
    strain.middleRows<6>(6 * g) = (elasticity_ * strain.middleRows<6>(6 * g)).eval();
  return strain;
}

namespace {

// Corners of a box about the origin: only the size matters.
Corners corners_of(const Vec3& size) {
  Corners corners;
  for (int k = 0; k < 8; ++k)
    for (int a = 0; a < 3; ++a)
      corners[static_cast<std::size_t>(k)][a] = 0.5 * sign_of(k, a) * size[a];
  return corners;
}

// Columns: displacements of the 24 degrees of freedom of the element for a unit value of each
// degree of freedom of the model.
Eigen::MatrixXd motion_of(bool flat) {
  Eigen::MatrixXd motion = Eigen::MatrixXd::Identity(24, 24);
  if (!flat) return motion;
  motion.setZero(24, 8);
  for (int k = 0; k < 8; ++k) {
    const int corner = (k & 1) | (k >> 2 & 1) << 1;
    motion(3 * k, 2 * corner) = motion(3 * k + 2, 2 * corner + 1) = 1;
  }
  return motion;
}

}  // namespace

// Plane strain and plane stress differ in D only; `motion` expresses that both faces have the same
// displacement and none along y.
ElementMatrices element_matrices(const Vec3& size, const Elastic& solid, Dimension dimension,
                                 PlaneState plane) {
  const bool flat = dimension == Dimension::plane;
  const Hexahedron solid_element(corners_of(size),
                                 elasticity(solid, flat && plane == PlaneState::stress));
  ElementMatrices matrices;
  const Eigen::MatrixXd motion = motion_of(flat);
  matrices.stiffness = motion.transpose() * solid_element.stiffness() * motion;
  matrices.centre_stress = solid_element.stress(Vec3::Zero()) * motion;
  matrices.top_stress = solid_element.stress(Vec3::UnitZ()) * motion;
  // Equal fractions: for a box this is also the row sum of the consistent mass.
  matrices.corner_mass = solid.density * size.prod() / (flat ? 4 : 8);
  return matrices;
}

// In a plane model a point represents two, front and back, with the same strains and stresses.
ElementPoints element_points(const Vec3& size, const Elastic& solid, Dimension dimension) {
  const bool flat = dimension == Dimension::plane;
  const Hexahedron element(corners_of(size), elasticity(solid));
  ElementPoints points;
  points.components = flat ? 4 : 6;
  points.volume = Eigen::VectorXd::Constant(flat ? 4 : 8, size.prod() / (flat ? 4 : 8));
  const int count = flat ? 4 : 8, rows = points.components * count;
  const Eigen::MatrixXd relief = element.relief(), motion = motion_of(flat);
  points.recovery.setZero(rows, motion.cols());
  points.relief.setZero(rows, rows);
  const auto shown = [&](int g) { return flat ? (g & 1) | (g >> 2 & 1) << 1 : g; };
  for (int g = 0; g < 8; ++g) {
    if (flat && (g >> 1 & 1) != 0) continue;  // the back equals the front
    const Eigen::MatrixXd recovery = element.stress(gauss_point(g)) * motion;
    for (int c = 0; c < points.components; ++c) {
      const int row = points.components * shown(g) + c;
      points.recovery.row(row) = recovery.row(points.voigt(c));
      for (int h = 0; h < 8; ++h)
        for (int d = 0; d < points.components; ++d)
          points.relief(row, points.components * shown(h) + d) +=
              relief(6 * g + points.voigt(c), 6 * h + points.voigt(d));
    }
  }
  return points;
}

}  // namespace trackbed::fem
