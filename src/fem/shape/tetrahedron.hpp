// Ten-node tetrahedron: quadratic displacement on four Gauss points, edges straight or curved.
//
// Four points integrate the stiffness of a straight tetrahedron exactly (Hammer, Marlowe, Stroud
// 1956) and leave no zero-energy modes except the rigid motions: 4 x 6 strains, 30 - 6 degrees of
// freedom. It bends without locking; values of Poisson's ratio near 1/2 are accurate as documented
// in docs/verification.md. Linear tetrahedra are worse in both and not supported. See
// docs/decisions/ground_from_files.md.
#pragma once

#include <Eigen/Dense>
#include <array>

#include "trackbed/core/types.hpp"

namespace trackbed::fem {

// Corners 0 to 3, then mid-edge nodes of edges 01 12 02 03 13 23 (VTK's order). Corner 3 is on the
// side to which the normal of 0, 1, 2 points.
using TenNodes = std::array<Vec3, 10>;
constexpr std::array<std::array<int, 2>, 6> tetrahedron_edges = {
    {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
// Faces as 6-node triangles, counter-clockwise seen from outside: corners, then mid-edge nodes of
// their edges 01 12 20.
constexpr std::array<std::array<int, 6>, 4> tetrahedron_faces = {
    {{0, 2, 1, 6, 5, 4}, {0, 1, 3, 4, 8, 7}, {1, 2, 3, 5, 9, 8}, {0, 3, 2, 7, 9, 6}}};

// A point of a tetrahedron by xi: its volume coordinates of corners 1, 2 and 3; that of corner 0 is
// 1 minus their sum.
constexpr int tetrahedron_points = 4;
constexpr double tetrahedron_weight = 1.0 / 24;  // of each Gauss point; the unit volume is 1/6
Vec3 tetrahedron_point(int gauss);
const Vec3& tetrahedron_centre();
Vec3 tetrahedron_face_centre(int face);

using TenNumbers = Eigen::Matrix<double, 10, 1>;
TenNumbers tetrahedron_shape(const Vec3& xi);
Eigen::Matrix<double, 10, 3> tetrahedron_gradients(const Vec3& xi);  // by xi
Mat3 tetrahedron_jacobian(const TenNodes& nodes, const Vec3& xi);    // m, d x_i / d xi_a

// Weights of the Gauss points in the linear extrapolation of their values to xi.
Eigen::Vector4d tetrahedron_weights(const Vec3& xi);

double tetrahedron_volume(const TenNodes& nodes);  // m^3
// 12 (3 V)^(2/3) over the sum of the squared edges, from the corners: 1 for an equilateral
// tetrahedron, 0 for a flat one (Liu, Joe 1994, doi:10.1007/BF01955874).
double tetrahedron_mean_ratio(const TenNodes& nodes);
// Its least value that a mesh may have. An element below it is some 2000 times as wide as high: no
// layer of a ground, but a file with a wrong scale in one direction, and explicit steps would be as
// short.
constexpr double least_mean_ratio = 0.005;
// Nodal volumes, m^3, from the integrals of the shape functions: the consistent distribution of a
// uniform weight. Below 0 at corners, so not usable as mass.
TenNumbers tetrahedron_load(const TenNodes& nodes);
// Fractions of the volume for a lumped mass: those of the diagonal of the consistent mass (Hinton,
// Rock, Zienkiewicz 1976, doi:10.1002/eqe.4290040305) of a straight tetrahedron; 1/36 at a corner,
// 4/27 at mid-edge. Row sums would make the masses of corners negative.
double tetrahedron_mass_fraction(int node);

}  // namespace trackbed::fem
