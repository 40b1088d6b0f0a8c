// Parameters of the breakage of corners.
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
}

}  // namespace trackbed::dem
