// One bond: its springs, stresses and damage.
#pragma once

#include "dem/state/state.hpp"
#include "trackbed/dem/bond.hpp"

namespace trackbed::dem {

// Known on the ranks of both stones, which compute the same. Members have 8 bytes, so that there is
// no padding: migration and the state hash use the bytes.
struct Bond {
  std::int64_t first, second;  // ids, first < second
  std::int64_t kind;           // number of its BondParameters
  double arm[2][3];            // m, from both centres of mass to the bond, in principal axes
  double axes[2][4];           // quaternions from its axes to the principal ones; x: its normal
  double radius, length;       // m
  double beyond;               // m, beyond the balls around both stones, at which it breaks
  double worst;                // largest stress over strength up to now
  double released;             // J, elastic energy that damage has taken up to now

  bool operator<(const Bond& o) const {
    return first != o.first ? first < o.first : second < o.second;
  }
};
inline constexpr int bond_numbers = 19;  // members of 8 bytes behind the three whole numbers

// Area, m^2, and section moduli against bending and torsion, m^3.
struct BondSection {
  double area, bending, torsion;
};
BondSection section_of(const Bond& bond, const Domain& domain);

// N/m and Nm/rad. In a plane there is no torsion.
struct BondStiffness {
  double normal, shear, bending, torsion;
};
BondStiffness stiffness_of(const Bond& bond, const BondParameters& p, const Domain& domain);

// Of one of both stones. The second one is at the image beside the first.
struct BondedBody {
  Vec3 x;  // m
  Quat q;
  Vec3 v, w;       // m/s, rad/s
  double mass;     // kg; infinite: it is held
  double inertia;  // kg m^2, the smallest principal moment
};

// A bond without force between two stones, `point` m, along the unit vector `normal` from the first
// to the second.
Bond make_bond(Id first, Id second, int kind, const BondedBody& i, const BondedBody& j,
               const Vec3& point, const Vec3& normal, double radius);

struct BondResponse {
  Vec3 point;              // m, middle of the bond
  Vec3 force, moment;      // N, Nm, on the first stone at that point, springs and dampers
  Vec3 elastic, twisting;  // of springs alone
  double normal, shear;    // Pa, of the undamaged bond; tension is positive
  double energy;           // J
  double dissipated;       // W, by dampers
};

// With the damage that follows from bond.worst. The force derives from the energy of the springs,
//   U = 1/2 (k_n u_n^2 + k_s u_s^2 + k_b phi_b^2 + k_t phi_t^2),
// with the displacement u and the rotation phi of the second place relative to the first, in axes
// midway between those of both stones: rotating both together gives no force, and momentum and
// angular momentum are kept. Energy is kept up to a term of the third order in u and phi.
BondResponse respond(const Bond& bond, const BondParameters& p, const Domain& domain,
                     const BondedBody& i, const BondedBody& j);

// Largest stress over its strength.
double utilisation(const BondResponse& r, const BondParameters& p);
bool by_shear(const BondResponse& r, const BondParameters& p);
double damage(double worst, const BondParameters& p);  // 0 to 1; 1: broken

}  // namespace trackbed::dem
