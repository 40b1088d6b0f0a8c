// Parameters of bonds.
#include "trackbed/dem/bond.hpp"

namespace trackbed::dem {

// Bonds store the number of their table: values may be changed for a later run, names and their
// order may not.
void BondParameters::declare(input::Section& s) {
  {
    const auto fixed = s.fixed_by(input::state::earlier);
    s.text("name", name, "Name of these bonds in the report on screen and in overrides.", {}, true);
  }
  s.flag("present", present, "Whether these bonds are made; for variants by an override.");
  s.text(
      "from", from,
      "Stage at whose begin the bonds are made; none: the first stage of kind load or passage, of "
      "placed stones the first stage.");
  s.numbers("low", low, {.unit = "m"},
            "Lower corner (x, y, z) of the box in which bonds are made; without low and high "
            "everywhere. The place of the contact counts.");
  s.numbers("high", high, {.unit = "m"}, "Upper corner of this box.");
  s.text("material", material, "Material of both stones; none: of any material.");
  s.number(
      "gap", gap, {.unit = "m", .at_least = 0, .usually_to = 0.01},
      "Balls, also those of clumps, are bonded across gaps up to this one. Stones with corners "
      "are bonded where they touch.");
  s.number("young", young, {.unit = "Pa", .above = 0, .usually_from = 1e5, .usually_to = 1e12},
           "Young's modulus of the bond, a beam between the centres of both stones. Stiff bonds "
           "reduce the sub-step.");
  s.number("shear_ratio", shear_ratio, {.unit = "-", .above = 0, .usually_to = 1},
           "Shear modulus of the bond divided by its Young's modulus.");
  s.number("radius", radius, {.unit = "-", .above = 0, .at_most = 2},
           "Radius of the section of the bond divided by that of the ball that has the volume of "
           "the smaller stone.");
  s.number("tension", tension, {.unit = "Pa", .above = 0, .usually_from = 1e3, .usually_to = 1e9},
           "Tensile strength: the bond breaks at this stress at the edge of its section.");
  s.number("shear", shear, {.unit = "Pa", .above = 0, .usually_from = 1e3, .usually_to = 1e9},
           "Shear strength.");
  s.number("moment", moment, {.unit = "-", .at_least = 0, .at_most = 1},
           "Part of bending and torsion that counts in the stresses; 0: they break no bond.");
  s.number("softening", softening, {.unit = "-", .at_least = 1, .usually_to = 100},
           "Deformation at which a damaged bond breaks, divided by that at which its strength is "
           "reached and damage begins; in between its force falls linearly. 1: it breaks at once.");
  s.number("damping", damping, {.unit = "-", .at_least = 0, .at_most = 1},
           "Viscous damping ratio of the bond against all relative motion of both stones.");
}

}  // namespace trackbed::dem
