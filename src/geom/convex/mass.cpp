// Centre and principal axes from integrals over a body, for bodies in space and laminas.
//
// With C = <x x^T> - <x><x>^T, the covariance of position over the body, m^2, the inertia about the
// centre is m (tr(C) 1 - C). Both have the same principal axes. `gyration`, the inertia over the
// mass, is stored, so that it scales with the square of the size only.
#include "geom/convex/mass.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace trackbed::geom {

namespace {

// Covariance of position about the centre, m^2. It is a difference of large numbers if the origin
// is far from the body: callers sum about a point inside.
Mat3 spread(const Integrals& integrals, const Vec3& centre) {
  return integrals.second / integrals.volume - centre * centre.transpose();
}

}  // namespace

// Exact moments of a simplex with corners 0, a, b, c and s = a + b + c:
//   V = a . (b x c) / 6,  int x = V s / 4,  int x x^T = V (s s^T + a a^T + b b^T + c c^T) / 20.
void add_tetrahedron(const Vec3& a, const Vec3& b, const Vec3& c, Integrals& sums) {
  const double volume = a.dot(b.cross(c)) / 6;  // with the origin
  const Vec3 s = a + b + c;
  sums.volume += volume;
  sums.first += volume / 4 * s;
  sums.second +=
      volume / 20 * (s * s.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
}

// The solver returns eigenvalues in rising order, so the first axis is the longest of the body.
// Equal eigenvalues (ball, cube) leave the axes undetermined: any are correct, and rounding selects
// them.
Solid solid_of(const Integrals& integrals) {
  Solid solid;
  solid.volume = integrals.volume;
  solid.centre = integrals.first / integrals.volume;
  const Mat3 covariance = spread(integrals, solid.centre);
  const Mat3 inertia = covariance.trace() * Mat3::Identity() - covariance;  // over mass
  const Eigen::SelfAdjointEigenSolver<Mat3> principal(inertia);
  solid.gyration = principal.eigenvalues();
  Mat3 axes = principal.eigenvectors();
  if (axes.determinant() < 0) axes.col(2) *= -1;  // a rotation, not a mirror
  solid.axes = Quat(axes);
  return solid;
}

// In the plane the solver is not used: it would order the axes by size, and a lamina's polar axis
// (the largest moment) must stay y, about which plane stones rotate. The covariance in y is 0, so
// the moment about y is the sum of those along x and z, and the moments about x and z are the
// covariance along the other axis.
Solid lamina_of(const Integrals& integrals) {
  Solid solid;
  solid.volume = integrals.volume;
  solid.centre = integrals.first / integrals.volume;
  const Mat3 s = spread(integrals, solid.centre);
  const double mean = (s(0, 0) + s(2, 2)) / 2, half = (s(0, 0) - s(2, 2)) / 2;
  const double radius = std::hypot(half, s(0, 2));
  // Mohr's circle: the axis of largest covariance is at `angle` from x towards z, a rotation about
  // -y.
  const double angle = radius == 0 ? 0 : std::atan2(s(0, 2), half) / 2;
  solid.gyration = {mean - radius, 2 * mean, mean + radius};
  solid.axes = Quat(Eigen::AngleAxisd(-angle, Vec3::UnitY()));
  return solid;
}

}  // namespace trackbed::geom
