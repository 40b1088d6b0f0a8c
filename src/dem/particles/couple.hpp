// A moment on a surface as forces on the nodes of one triangle, and the spin of the triangle that
// is conjugate to this moment.
//
// Across the face: forces along the normal n_f that follow the gradients of the shape functions
// phi, F_k = (n_f x m) . grad phi_k n_f. Their sum is zero and their moment is the part of m in the
// face. Along n_f: forces in the face around its centre. Both are exact for any triangle, and both
// do work on `spin` only: sum F_k . u_k = m . spin for any motion u_k of the nodes.
#pragma once

#include <array>

#include "dem/shape/mesh.hpp"

namespace trackbed::dem {

class Couple {
 public:
  // At the fraction `s` of the window.
  Couple(const Surface& surface, int triangle, double s);
  // N on each node, from a moment (Nm).
  std::array<Vec3, 3> forces(const Vec3& moment) const;
  // rad, rotation of the triangle in a window.
  const Vec3& spin() const { return spin_; }

 private:
  Vec3 normal_;
  std::array<Vec3, 3> gradient_;  // 1/m
  std::array<Vec3, 3> arm_;       // m, from the centre
  double square_ = 0;             // m^2, of the arms
  Vec3 spin_;
};

}  // namespace trackbed::dem
