// Forces and stresses of the ten-node tetrahedra that a rank holds, without matrices.
//
// Eight elements are computed side by side in the lanes of a vector, gathered and scattered node by
// node; only the inverse Jacobians at the Gauss points of each are stored (320 bytes; its matrix
// has 7200). Elements are added to nodes in ascending order: bitwise identical on any number of
// ranks. About 1900 flops per element.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "fem/material/mohr_coulomb.hpp"
#include "fem/mesh/mesh.hpp"
#include "fem/shape/element.hpp"
#include "fem/shape/lanes.hpp"
#include "fem/shape/tetrahedron.hpp"

namespace trackbed::fem {

// Constant after construction; local. Refers to the mesh, which must outlive it.
class Tetrahedra {
 public:
  Tetrahedra(const Mesh& mesh, double common_damping);

  // f += K u on own nodes; ghosts of u must be current.
  void add_force(const Nodal& u, Nodal& f) const { run(u, f, false); }
  // f += (beta - common_damping) K v over solids with another stiffness damping beta, s.
  bool damps() const { return damps_; }
  void add_damping(const Nodal& v, Nodal& f) const { run(v, f, true); }

  // N/m, 30 x 30; degree of freedom 3 * node + component.
  Eigen::MatrixXd matrix(std::size_t element) const;
  // Pa, xx yy zz xy yz zx at xi (tetrahedron.hpp).
  Vec6 stress(std::size_t element, const Vec3& xi, const Nodal& u) const;
  // For yielding at the Gauss points (plasticity_tetrahedra.cpp): groups of eight elements, from 8
  // * group on. Pa, due to the motion u0 + u; due to a strain; f -= their forces, of marked
  // lanes.
  using Points = Lane[6][tetrahedron_points];
  void stress(std::size_t group, const Nodal& u0, const Nodal& u, Points& stress) const;
  void hooke(std::size_t group, const Points& strain, Points& stress) const;
  void take_off(std::size_t group, const Points& stress, const std::uint8_t (&marked)[lanes],
                Nodal& f) const;
  double volume(std::size_t element, int point) const {  // m^3
    return groups_[element / lanes].volume[point][static_cast<int>(element % lanes)];
  }
  ElementPoints points(std::size_t element) const;
  TenNodes nodes_of(std::size_t element) const;  // m
  std::size_t bytes() const { return groups_.capacity() * sizeof(Group); }

 private:
  struct Group {
    Lane inverse[4][3][3];    // 1/m, d xi_a / d x_j at the Gauss points
    Lane volume[4];           // m^3 of each point; 0 beyond the last element
    Lane lame, shear, damps;  // Pa, Pa, s: damping minus the common one
  };
  void fill(std::size_t element, Group& group, std::size_t lane, double common_damping) const;
  void run(const Nodal& u, Nodal& f, bool damping) const;

  const Mesh& mesh_;
  std::vector<Group> groups_;
  bool damps_ = false;
};

}  // namespace trackbed::fem
