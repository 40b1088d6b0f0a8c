// Eight-node hexahedron with enhanced strains: no locking in bending or near incompressibility.
//
// The assumed strain is B u + E alpha with 12 element parameters alpha that are condensed out: the
// nine of Wilson's incompatible modes (Wilson, Taylor, Doherty, Ghaboussi 1973; Taylor, Beresford,
// Wilson 1976, doi:10.1002/nme.1620100602) written as enhanced strains (Simo, Rifai 1990,
// doi:10.1002/nme.1620290802) and three that relax the volumetric part of the xi*eta-like terms
// (Simo, Armero, Taylor 1993, doi:10.1016/0045-7825(93)90215-J). E integrates to zero against
// constant stress on any shape, so the patch test is satisfied. See
// docs/decisions/ground_elements.md.
#pragma once

#include <Eigen/Core>
#include <array>

#include "trackbed/core/types.hpp"
#include "trackbed/fem/ground.hpp"

namespace trackbed::fem {

// Corners of a brick, as bits x, y, z, in the order of VTK.
constexpr std::array<std::size_t, 8> vtk_corner = {0, 1, 3, 2, 4, 5, 7, 6};

// Corner k is at xi = +1 if bit 0 of k is set (else -1), eta: bit 1, zeta: bit 2.
using Corners = std::array<Vec3, 8>;
// Order xx yy zz xy yz zx with engineering shear strains.
using Voigt = Eigen::Matrix<double, 6, 6>;

// Lame's constants, Pa: sigma = lame tr(e) I + 2 shear e.
struct Lame {
  double lame, shear;
};
Lame lame_of(const Elastic& solid);

// Hooke's law, Pa. `sigma_y_free` condenses sigma_y = 0 (plane stress in x, z).
Voigt elasticity(const Elastic& solid, bool sigma_y_free = false);

class Hexahedron {
 public:
  Hexahedron(const Corners& corners, const Voigt& elasticity);

  // N/m; degree of freedom 3 * corner + component.
  const Eigen::Matrix<double, 24, 24>& stiffness() const { return stiffness_; }
  // Stress (Pa) at a point of the unit cube from the corner displacements.
  Eigen::Matrix<double, 6, 24> stress(const Vec3& xi) const;
  // Stress (Pa) at all Gauss points due to plastic strain at all of them, corners held: -D at the
  // point itself, plus the effect of the enhanced strains. Index 6 * point + component, points as
  // corners.
  Eigen::MatrixXd relief() const;

 private:
  Mat3 jacobian(const Vec3& xi) const;
  Eigen::Matrix<double, 6, 24> compatible(const Vec3& xi) const;
  Eigen::Matrix<double, 6, 12> enhanced(const Vec3& xi) const;

  Corners corners_;
  Voigt elasticity_;
  Mat3 centre_inverse_;  // inverse Jacobian at the centre
  double centre_volume_;
  Eigen::Matrix<double, 12, 24> alpha_;  // element parameters from displacements
  Eigen::Matrix<double, 24, 24> stiffness_;
};

// An element of the regular mesh with the degrees of freedom of the model: 24 in space, 8 in a
// plane, where front and back nodes have the same displacement. Degree of freedom d * corner +
// component; plane corners by (x, z) bits.
struct ElementMatrices {
  Eigen::MatrixXd stiffness;
  Eigen::MatrixXd centre_stress, top_stress;  // 6 rows; at the centres of element and top face
  double corner_mass = 0;                     // kg, lumped
};
ElementMatrices element_matrices(const Vec3& size, const Elastic& solid, Dimension dimension,
                                 PlaneState plane);

// The Gauss points of an element, for plastic strain: 8 in space, 4 in a plane (of plane strain),
// where front and back are equal, numbered as the corners; 4 of a tetrahedron.
struct ElementPoints {
  int components = 6;        // of stress and strain: in a plane xx yy zz zx
  Eigen::VectorXd volume;    // m^3 of each
  Eigen::MatrixXd recovery;  // Pa/m: row components * point + component, columns of ElementMatrices
  Eigen::MatrixXd relief;    // Pa: stress by plastic strain of all points, corners held
  // N from Pa at the points, row components * point + component.
  Eigen::MatrixXd weighted(const Eigen::MatrixXd& rows) const {
    return volume.replicate(1, components).transpose().reshaped().asDiagonal() * rows;
  }
  // Index of a component in xx yy zz xy yz zx.
  int voigt(int component) const { return components == 4 && component == 3 ? 5 : component; }
};
ElementPoints element_points(const Vec3& size, const Elastic& solid, Dimension dimension);

}  // namespace trackbed::fem
