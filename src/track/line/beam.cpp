// Interdependent interpolation: w is cubic and theta quadratic in x such that the shear strain is
// constant and the homogeneous equations of the Timoshenko beam hold exactly. So nodal deflections
// under nodal loads are exact for any element length, there is no shear locking, and Phi = 0 gives
// the Hermite element of the Euler-Bernoulli beam.
//   w = N(xi) u,   theta = T(xi) u,   Phi = 12 E I/(k G A L^2)
// (Friedman and Kosmatka 1993, doi:10.1016/0045-7949(93)90243-7.)
// Rejected: independent linear w and theta with reduced integration, which need about ten times as
// many elements between sleepers for the same deflection.
#include "track/line/beam.hpp"

#include <array>
#include <cmath>

namespace trackbed::track {

// A beam rigid in shear has Phi = 0.
BeamElement::BeamElement(const Beam& beam, double length) : beam_(beam), length_(length) {
  const double squared = length * length;
  shear_ =
      beam.shear_stiffness > 0 ? 12 * beam.bending_stiffness / (beam.shear_stiffness * squared) : 0;
}

// Degrees of freedom w1, theta1, w2, theta2; Hermite cubics plus Phi times linear and quadratic
// terms.
Four BeamElement::deflection(double xi) const {
  const double square = xi * xi, cube = square * xi;
  const double p = shear_, l = length_;
  return Four(1 - 3 * square + 2 * cube + p * (1 - xi),
              l * (xi - 2 * square + cube + p / 2 * (xi - square)), 3 * square - 2 * cube + p * xi,
              l * (cube - square - p / 2 * (xi - square))) /
         (1 + p);
}

// theta = dw/dx - shear strain, which is constant in the element.
Four BeamElement::rotation(double xi) const {
  const double square = xi * xi;
  const double p = shear_, l = length_;
  return Four(6 / l * (square - xi), 1 - 4 * xi + 3 * square + p * (1 - xi), 6 / l * (xi - square),
              3 * square - 2 * xi + p * xi) /
         (1 + p);
}

// Closed form of the integral of E I theta'^2 + k G A (w' - theta)^2.
Matrix4 BeamElement::stiffness() const {
  const double l = length_, p = shear_;
  Matrix4 k;
  k << 12, 6 * l, -12, 6 * l,                           //
      6 * l, (4 + p) * l * l, -6 * l, (2 - p) * l * l,  //
      -12, -6 * l, 12, -6 * l,                          //
      6 * l, (2 - p) * l * l, -6 * l, (4 + p) * l * l;
  return k * (beam_.bending_stiffness / ((1 + p) * l * l * l));
}

// Gauss quadrature with four points: exact for the products of cubics used here.
template <class M, class F>
M BeamElement::integral(const std::array<double, 2>& part, F&& integrand) const {
  constexpr std::array<double, 2> at = {0.339981043584856265, 0.861136311594052575};
  constexpr std::array<double, 2> weight = {0.652145154862546143, 0.347854845137453857};
  const double half = (part[1] - part[0]) / 2;
  M sum = M::Zero();
  for (std::size_t i = 0; i < 2; ++i)
    for (const double side : {-1.0, 1.0})
      sum += weight[i] * length_ * half * integrand(part[0] + half * (1 + side * at[i]));
  return sum;
}

// Consistent mass matrix with rotary inertia.
Matrix4 BeamElement::mass() const {
  return integral<Matrix4>({0, 1}, [this](double xi) -> Matrix4 {
    const Four w = deflection(xi), turn = rotation(xi);
    return beam_.mass * w * w.transpose() + beam_.rotary_inertia * turn * turn.transpose();
  });
}

Matrix4 BeamElement::bed(const std::array<double, 2>& part) const {
  return integral<Matrix4>(part, [this](double xi) -> Matrix4 {
    const Four w = deflection(xi);
    return w * w.transpose();
  });
}

Four BeamElement::area(const std::array<double, 2>& part,
                       const std::array<double, 2>& times) const {
  return integral<Four>(part, [&](double xi) -> Four {
    return (times[0] + (times[1] - times[0]) * xi) * deflection(xi);
  });
}

// The element divided at xi into two with a common node: exact, since both parts are. Without it a
// wheel between nodes would roll on a rail that is too stiff, by L/(4 k G A) of shear and
// L^3/(192 E I) of bending at mid-element, and would be excited at every element.
double BeamElement::local_flexibility(double xi) const {
  constexpr double at_node = 1e-9;
  if (xi < at_node || xi > 1 - at_node) return 0;
  const Matrix4 left = BeamElement(beam_, xi * length_).stiffness();
  const Matrix4 right = BeamElement(beam_, (1 - xi) * length_).stiffness();
  const Eigen::Matrix2d middle = left.bottomRightCorner<2, 2>() + right.topLeftCorner<2, 2>();
  return middle(1, 1) / middle.determinant();
}

}  // namespace trackbed::track
