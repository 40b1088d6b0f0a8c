// The finite element of the rail: two nodes, each a deflection w (m, upwards) and a rotation theta
// (rad, dw/dx where the beam does not shear). Freedoms in the order w1, theta1, w2, theta2.
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
  // Of a bed of 1 N/m per m (or 1 N s/m per m) under the element or under a part of it (from, to:
  // parts of its length), consistent.
  Matrix4 bed(const std::array<double, 2>& part = {0, 1}) const;
  // m, integral over a part of it of the shape functions of w times what is linear between these
  // values at its ends.
  Four area(const std::array<double, 2>& part, const std::array<double, 2>& times) const;
  Four deflection(double xi) const;  // shape functions of w at xi = x/length
  Four rotation(double xi) const;    // of theta
  // m/N: how far a unit force at xi moves its own point while both nodes are held: the part of the
  // deflection that nodes do not show.
  double local_flexibility(double xi) const;

 private:
  template <class M, class F>
  M integral(const std::array<double, 2>& part, F&& integrand) const;
  Beam beam_;
  double length_, shear_;  // m; Phi = 12 E I/(k G A L^2)
};

}  // namespace trackbed::track
