// Bonds: cemented joints between two stones, as in glued ballast and in agglomerates. A bond is an
// elastic beam between the places at which it was made, with stiffness against stretching, shear,
// bending and torsion (parallel bond: Potyondy and Cundall 2004,
// doi:10.1016/j.ijrmms.2004.09.011); it acts beside the contact of both stones and breaks for good.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trackbed/core/types.hpp"
#include "trackbed/input/section.hpp"

namespace trackbed::dem {

// A section of the radius R = radius times that of the smaller stone (of the ball of its volume)
// and the length L, the distance of both centres. In a plane model it is a rectangle of the width
// 2 R and the thickness of the model.
struct BondParameters {
  std::string name;
  bool present = true;
  std::string from;               // stage at whose begin bonds are made; none: the first under load
  std::vector<double> low, high;  // m, corners of the box in which they are made; none: all
  std::string material;           // of both stones; none: any
  double gap = 0;                 // m, largest distance of balls that are bonded
  double young = 1e9;             // Pa
  double shear_ratio = 0.4;       // shear modulus over Young's modulus
  double radius = 0.5;            // of the section, see above
  double tension = 1e6;           // Pa, strength
  double shear = 1e6;             // Pa, strength
  double moment = 1;              // part of bending and torsion that counts in the stress
  double softening = 1;           // deformation at which the force vanishes over that at strength
  double damping = 0;             // damping ratio of its springs
  void declare(input::Section& s);
};

struct BondView {
  Id first, second;
  int kind;                          // number of its BondParameters
  Vec3 first_centre, second_centre;  // m, of mass, the image that is bonded
  Vec3 point;                        // m, middle of the bond
  Vec3 force, moment;                // N, Nm, on the first stone at that point, of springs
  double utilisation;                // largest stress over its strength
  double damage;                     // 0 to 1, part of the stiffness that is lost
  double energy;                     // J
};

struct BondBreak {
  double time = 0;  // s, simulated since the particles exist
  Id first = 0, second = 0;
  int kind = 0;
  bool by_shear = false;         // else by tension
  Vec3 position = Vec3::Zero();  // m
  double normal = 0, shear = 0;  // Pa, stresses of the undamaged bond
  double energy = 0;             // J, elastic energy that damage took until it broke
};

struct BondTotals {
  std::int64_t made = 0, whole = 0;  // up to now; now
  std::int64_t by_tension = 0, by_shear = 0;
  double released = 0;  // J, elastic energy that damage took, also of bonds that are whole
};

}  // namespace trackbed::dem
