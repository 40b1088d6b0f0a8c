// Finite element of the rail: two nodes, each with a deflection w (m, upwards) and a rotation theta
// (rad, dw/dx without shear). Degrees of freedom in the order w1, theta1, w2, theta2.
#pragma once

#include <array>

#include "trackbed/core/types.hpp"
#include "trackbed/track/rail.hpp"

namespace trackbed::track {

using Four = Eigen::Vector4d;
using Matrix4 = Eigen::Matrix4d;

class BeamElement {
 public:
  BeamElement(const Beam& beam, double length);  // m
  Matrix4 stiffness() const;                     // N/m, N, N m
  Matrix4 mass() const;                          // kg, kg m, kg m^2, consistent
  // Consistent matrix of a bed of 1 N/m per m (or 1 N s/m per m) under the element or under a part
  // of it (from, to: relative to its length).
  Matrix4 bed(const std::array<double, 2>& part = {0, 1}) const;
  // m, integral over a part of the element of the shape functions of w times a linear function with
  // the values `times` at its ends.
  Four area(const std::array<double, 2>& part, const std::array<double, 2>& times) const;
  Four deflection(double xi) const;  // shape functions of w at xi = x/length
  Four rotation(double xi) const;    // of theta
  // m/N: deflection at xi due to a unit force there with both nodes fixed, which the nodal
  // displacements do not contain.
  double local_flexibility(double xi) const;

 private:
  template <class M, class F>
  M integral(const std::array<double, 2>& part, F&& integrand) const;
  Beam beam_;
  double length_, shear_;  // m; Phi = 12 E I/(k G A L^2)
};

}  // namespace trackbed::track
