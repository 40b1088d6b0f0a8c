// Six-node faces of the top as the flat triangles that stones touch, four each.
//
// A uniform pressure on a straight six-node face pulls on the nodes amid its edges alone, a third
// of the force each. Flat triangles give a twelfth to each corner as well, and such forces bend the
// uppermost elements however fine they are. So a corner of the surface does not show where the node
// is, but the plane through the middles of the edges of the faces around it, which have a share w
// of it by area:
//   u_top = T u,   at a corner: sum_f w_f (l_0 u_m0 + l_1 u_m1 + l_2 u_m2),   amid an edge: u_m
// with l the shares of the middles at the corner (1, 1 and -1 with straight edges), and forces on
// the surface go the way back, f = T' f_top. Then work and moments balance to rounding, as T keeps
// linear motions, a uniform pressure is the consistent one to the bit of its shares, and the corner
// shown is off that of the element by the square of its size. Rejected: forces to six nodes by
// quadratic shape functions, which needs curved surfaces in contacts; T' without T, whose work does
// not balance.
#pragma once

#include <span>
#include <vector>

#include "mesh.hpp"

namespace trackbed::fem {

// Constant once made. Refers to the mesh, which must outlive it.
class FlatTop {
 public:
  // mass: kg, of own nodes. Collective.
  FlatTop(Mesh& mesh, const std::vector<double>& mass);

  // T values at an own node of the top; ghosts of values must be current.
  Vec3 at(std::int32_t node, const Nodal& values) const;
  // Forces on own nodes of the surface become T' of them, and 0 on ghosts. Collective.
  void to_nodes(Nodal& force) const;
  // kg, at an own node of the top: with diag(1/m) no force moves the surface less than it does,
  // 1/m_i = sum_j |T M^-1 T'|_ij or more (Gershgorin).
  double mass(std::int32_t node) const;
  std::size_t bytes() const {
    return shares_.capacity() * sizeof(Share) + mass_.capacity() * sizeof(double);
  }

 private:
  struct Share {
    std::int32_t corner, middle;  // local nodes
    double weight;
  };
  void take(const Imported::Face& face);
  std::span<const Share> row(std::int32_t node) const;  // of a corner; else empty
  void weigh(const std::vector<double>& mass);

  Mesh& mesh_;
  std::vector<Share> shares_;  // corner by corner, ascending, of all faces held here
  std::vector<double> mass_;   // by local number
};

}  // namespace trackbed::fem
