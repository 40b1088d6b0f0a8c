// Parameters of breakage.
#include "trackbed/dem/breakage.hpp"

namespace trackbed::dem {

// Strengths belong to the number of a stone and not to the state: they change with these values.
void BreakageParameters::declare(input::Section& s) {
  s.number(
      "strength", strength, {.unit = "Pa", .at_least = 0, .usually_from = 1e5, .usually_to = 1e9},
      "Characteristic strength of corners (small pebbles of clumps), the sigma of F = sigma d^2 "
      "(d/diameter)^size_exponent [ln(1/P)]^(1/weibull): a pebble of the diameter d breaks off "
      "if the normal force of one of its contacts exceeds F. P is drawn for each pebble, so "
      "that 37 % of the pebbles are stronger than strength d^2 (d/diameter)^size_exponent. "
      "0: nothing breaks.");
  s.text("material", material, "Material of the stones whose corners break.");
  s.text("from", from,
         "Stage from which on corners break; none: the first stage of kind load or passage.");
  s.number("diameter", diameter, {.unit = "m", .above = 0, .usually_from = 1e-4, .usually_to = 0.2},
           "Characteristic diameter of a pebble, at which the size effect is 1.");
  s.number("size_exponent", size_exponent, {.unit = "-", .usually_from = -3, .usually_to = 3},
           "Exponent of the size effect: above 0, stress at failure rises with the diameter.");
  s.number("weibull", weibull, {.unit = "-", .above = 0, .usually_from = 1, .usually_to = 50},
           "Weibull modulus of the strength: the larger, the less it scatters.");
  s.number("threshold", threshold, {.unit = "-", .above = 0, .at_most = 1},
           "Pebbles break off if their radius is below this ratio to that of the largest pebble of "
           "their stone.");
  s.number(
      "birth_size", birth_size, {.unit = "-", .above = 0, .at_most = 1},
      "Size of a fragment at first, at most, divided by its final size. It is smaller if there "
      "is less space where the pebble was.");
  s.integer(
      "growth_steps", growth_steps, {.at_least = 1, .at_most = 1000000},
      "Number of sub-steps of the stones in which a fragment grows by half of its final size if "
      "there is space; large fragments beside small ones take longer.");
  s.number("growth_overlap", growth_overlap, {.unit = "-", .above = 0, .usually_to = 0.1},
           "A fragment waits with its growth while one of its contacts is compressed by more than "
           "this part of its final radius. The larger, the more work its growth can do on stones "
           "beside it.");
  s.number("least_size", least_size, {.unit = "m", .at_least = 0, .usually_to = 0.05},
           "Diameter of the smallest fragment; smaller ones are removed, and their mass is counted "
           "as fines. It limits the sub-step as a stone of this size does. 0: fragments as heavy "
           "as the lightest stone or heavier, which do not shorten the sub-step.");
  s.integer("seed", seed, {.at_least = 0, .at_most = 1000000000}, "Seed of the strengths.");
  s.integer("check_steps", check_steps, {.at_least = 1, .at_most = 1000000},
            "Number of sub-steps between two checks of stones with corners (splitting, cutting, "
            "wear). "
            "Each check costs about as much as two sub-steps.");
  s.table("splitting", splitting, "Stones with corners (polyhedra, compounds) that split in two.");
  s.table("cutting", cutting, "Corners of polyhedra that are crushed under contacts.");
  s.table("wear", wear, "Polyhedra that friction wears off.");
}

void WearParameters::declare(input::Section& s) {
  s.number("coefficient", coefficient, {.at_least = 0, .usually_from = 1e-6, .usually_to = 1},
           "Volume that a stone loses, times the hardness, divided by the work of friction at its "
           "contacts: Archard's coefficient divided by the coefficient of friction. 0: no wear.");
  s.number("hardness", hardness,
           {.unit = "Pa", .above = 0, .usually_from = 1e8, .usually_to = 2e10},
           "Hardness of the stones.");
  s.number("step", step, {.above = 0, .at_most = 0.05},
           "Ratio of the wear that is taken off at a time to the volume of the stone. Until then "
           "the stone keeps its shape and mass.");
}

void SplittingParameters::declare(input::Section& s) {
  s.number(
      "strength", strength, {.unit = "Pa", .at_least = 0, .usually_from = 1e5, .usually_to = 1e9},
      "Octahedral shear stress of a stone of the diameter `diameter` at which 37 % of such stones "
      "have not split. A stone of volume V between two platens at the distance h has 0.47 F h/V, a "
      "ball 0.9 F/d^2. 0: stones do not split.");
  s.number("diameter", diameter, {.unit = "m", .above = 0, .usually_from = 1e-3, .usually_to = 0.2},
           "Diameter of a ball of the volume of the stone to which the strength belongs. Larger "
           "stones are weaker: strength (d/diameter)^(-3/weibull).");
  s.number("weibull", weibull, {.unit = "-", .above = 0, .usually_from = 1, .usually_to = 50},
           "Weibull modulus of the strength.");
}

void CuttingParameters::declare(input::Section& s) {
  s.number(
      "strength", strength, {.unit = "Pa", .at_least = 0, .usually_from = 1e6, .usually_to = 1e10},
      "Characteristic pressure of a contact that a corner bears: a corner below a force F is cut "
      "off so that its new face has the area F/strength. 0: corners are not cut.");
  s.number("weibull", weibull, {.unit = "-", .above = 0, .usually_from = 1, .usually_to = 50},
           "Weibull modulus of the strength, which is drawn for each stone.");
  s.number("least_depth", least_depth, {.unit = "-", .above = 0, .at_most = 0.5},
           "Depth of a cut divided by the diameter of the ball of the stone's volume: corners are "
           "cut when they need at least this depth.");
  s.number("largest_depth", largest_depth, {.unit = "-", .above = 0, .at_most = 0.5},
           "Largest depth of a cut, as a ratio like least_depth; if a corner needs more, it is cut "
           "again at the next check.");
  s.rule("largest_depth", largest_depth > least_depth, "must be above least_depth");
}

}  // namespace trackbed::dem
