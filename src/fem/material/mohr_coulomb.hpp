// Mohr-Coulomb strength with a tension cut-off, without hardening: return mapping of a stress.
//
// In principal stresses s1 >= s2 >= s3 (tension positive) the admissible set is convex,
//   N s1 - s3 <= 2 c sqrt N,  N = (1 + sin phi) / (1 - sin phi),  s1 <= tensile strength,
// and the same with s2 for s3, s2 for s1, which is relevant at the edges (Koiter 1953). The plastic
// strain increment is along the normals of the planes with the dilation angle for phi, that of the
// cut-off is associated: backward Euler, exact, as all planes are linear.
#pragma once

#include <Eigen/Dense>
#include <array>

#include "fem/shape/element.hpp"
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

// Pure functions of one point.
class MohrCoulomb {
 public:
  MohrCoulomb(const Elastic& solid, const Strength& strength);

  // Returns a stress beyond the yield surface to it; `plastic` is the plastic strain increment.
  // Leaves a stress within it exactly unchanged and returns false. `slope`: the derivative of the
  // returned stress by the given one, both in Voigt's order; not set if false.
  bool bring_back(Vec6& stress, Vec6& plastic, Voigt* slope = nullptr) const;
  // Pa, yield function of principal stresses (any order); below 0: within the surface.
  double beyond(const Vec3& stress) const;
  // Whether a returned stress is on the cut-off: the plastic strain includes opening.
  bool opens(const Vec6& stress) const;

  // A stress is within the surface if, with p the mean and J the second invariant of the deviator,
  // r = limit - slope p >= 0 and factor J <= r^2, for both cones: no principal values are needed.
  struct Cone {
    double limit, slope, factor;  // Pa, -, -
  };
  const std::array<Cone, 2>& cones() const { return cones_; }

 private:
  struct Plane {
    Vec3 normal, flow;  // of the yield plane; of plastic strain
    double limit;       // Pa: normal . stress <= limit
    Vec3 back;          // Pa: stress reduction by a unit plastic multiplier
  };
  // Return along the planes of `set` (bits); false if another set is active.
  bool try_set(unsigned set, double rounding, Vec3& stress, Vec3& plastic) const;
  Mat3 principal_slope(unsigned set) const;

  std::array<Plane, 6> planes_;
  std::array<Cone, 2> cones_;
};

}  // namespace trackbed::fem
