// Six-node faces of the top, represented by four flat triangles each, which stones touch.
//
// A uniform pressure on a straight six-node face loads only the nodes at mid-edge, with a third of
// the force each. Flat triangles put a twelfth on each corner as well, and such forces bend the
// uppermost elements, however fine they are. So a corner of the surface is not at the position of
// the node, but on the plane through the mid-edge nodes of the faces around it, which are weighted
// with their fraction w of the area:
//   u_top = T u,   at a corner: sum_f w_f (l_0 u_m0 + l_1 u_m1 + l_2 u_m2),   at mid-edge: u_m
// with l the weights of the mid-edge nodes at the corner (1, 1 and -1 with straight edges), and
// forces on the surface are transformed with the transpose, f = T' f_top. Then work and moments
// balance to rounding, as T preserves linear motions, a uniform pressure yields the consistent
// nodal forces to the rounding of the weights, and the distance of the corner from that of the
// element is second order in the element size. Rejected: forces to six nodes by quadratic shape
// functions, which needs curved surfaces in contacts; T' without T, whose work does not balance.
#pragma once

#include <span>
#include <vector>

#include "fem/mesh/mesh.hpp"

namespace trackbed::fem {

// Constant after construction. Refers to the mesh, which must outlive it.
class FlatTop {
 public:
  // mass: kg, of own nodes. Collective.
  FlatTop(Mesh& mesh, const std::vector<double>& mass);

  // T values at an own node of the top; ghosts of values must be current.
  Vec3 at(std::int32_t node, const Nodal& values) const;
  // Replaces forces on own nodes of the surface by T' times them, and sets 0 on ghosts. Collective.
  void to_nodes(Nodal& force) const;
  // kg, at an own node of the top: with diag(1/m) no force accelerates the surface less than in the
  // model, 1/m_i = sum_j |T M^-1 T'|_ij or more (Gershgorin).
  double mass(std::int32_t node) const;
  std::size_t bytes() const {
    return entries_.capacity() * sizeof(Entry) + mass_.capacity() * sizeof(double);
  }

 private:
  struct Entry {
    std::int32_t corner, middle;  // local nodes
    double weight;
  };
  void take(const Imported::Face& face);
  std::span<const Entry> row(std::int32_t node) const;  // of a corner; else empty
  void compute_mass(const std::vector<double>& mass);

  Mesh& mesh_;
  std::vector<Entry> entries_;  // corner by corner, ascending, of all faces held here
  std::vector<double> mass_;    // by local number
};

}  // namespace trackbed::fem
