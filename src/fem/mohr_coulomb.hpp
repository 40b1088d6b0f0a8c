// Mohr-Coulomb strength with a tension cut-off, without hardening: return of a stress to the
// surface.
//
// In principal stresses s1 >= s2 >= s3 (tension positive) what can be carried is a convex body,
//   N s1 - s3 <= 2 c sqrt N,  N = (1 + sin phi) / (1 - sin phi),  s1 <= tensile strength,
// and the same with s2 for s3, s2 for s1, which matter at the edges (Koiter 1953). Plastic strain
// flows along the normals of the planes with the dilation angle for phi, those of the cut-off along
// their own: backward Euler, exact, as all is linear.
#pragma once

#include <Eigen/Dense>
#include <array>

#include "element.hpp"
#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

// xx yy zz xy yz zx; stress in Pa, tension positive; strain with shear doubled.
using Vec6 = Eigen::Matrix<double, 6, 1>;

// Largest first. `axes`: columns in the order of the values.
struct Principal {
  Vec3 value;
  Mat3 axes;
};
Principal principal(const Vec6& stress);

// Pure arithmetic on one point.
class MohrCoulomb {
 public:
  MohrCoulomb(const Elastic& solid, const Strength& strength);

  // Takes a stress beyond the surface back to it; `plastic` is the strain that flowed. Leaves a
  // stress within it alone, to the bit, and says false.
  // `slope`: the derivative of the stress on the surface by the one given, both as they stand in
  // Voigt's order; not set if false.
  bool bring_back(Vec6& stress, Vec6& plastic, Voigt* slope = nullptr) const;
  // Pa, how far principal stresses (any order) are beyond the surface; below 0: within.
  double beyond(const Vec3& stress) const;
  // Whether a stress that was brought back lies on the cut-off: what flowed has opened.
  bool opens(const Vec6& stress) const;

  // A stress is within the surface if, with p the mean and J the second invariant of the deviator,
  // r = limit - slope p >= 0 and factor J <= r^2, for both: no principal values needed.
  struct Cone {
    double limit, slope, factor;  // Pa, -, -
  };
  const std::array<Cone, 2>& cones() const { return cones_; }

 private:
  struct Plane {
    Vec3 normal, flow;  // of yield; of plastic strain
    double limit;       // Pa: normal . stress <= limit
    Vec3 back;          // Pa: stress taken off by unit flow
  };
  // Return along the planes of `set` (bits); false if another set holds.
  bool try_set(unsigned set, double rounding, Vec3& stress, Vec3& plastic) const;
  Mat3 principal_slope(unsigned set) const;

  std::array<Plane, 6> planes_;
  std::array<Cone, 2> cones_;
};

}  // namespace trackbed::fem
