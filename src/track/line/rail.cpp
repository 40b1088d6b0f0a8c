// The library of rails, and beam properties from a section or from values.
// Names are those of EN 13674-1 (46E3, 54E1, 60E1), UIC 861-1 and 861-3 (UIC54, UIC60), TB/T 2341
// (CHN60). Wear is not included: give values for a worn rail.
#include "trackbed/track/rail.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "trackbed/core/error.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::track {

// Where the standard's mass per length is not known, it is the area times 7850 kg/m^3.
const std::vector<RailSection>& rail_sections() {
  static const std::vector<RailSection> sections = {
      {"46E3", 59.44e-4, 1606e-8, 46.66,
       "area and inertia from EN 13674-1; mass from the area and a density of 7850 kg/m3"},
      {"54E1", 69.77e-4, 2337.2e-8, 54.77,
       "area and inertia from EN 13674-1; mass from the area and a density of 7850 kg/m3"},
      {"60E1", 76.70e-4, 3038.3e-8, 60.21, "EN 13674-1"},
      {"UIC54", 69.77e-4, 2337.2e-8, 54.77, "former name of 54E1 (UIC 861-1)"},
      {"UIC60", 76.70e-4, 3038.3e-8, 60.21, "former name of 60E1 (UIC 861-3)"},
      {"CHN60", 77.45e-4, 3217e-8, 60.64,
       "inertia and mass from TB/T 2341; area not verified against the standard"}};
  return sections;
}

// Decks are checked before; this check is for callers from code.
const RailSection& rail_section(std::string_view name) {
  std::vector<std::string> known;
  for (const RailSection& section : rail_sections()) {
    if (section.name == name) return section;
    known.emplace_back(section.name);
  }
  throw InputError({fmt::format("rail.section = \"{}\" is unknown; known sections: {}", name,
                                fmt::join(known, ", "))});
}

// For a worn or special rail give its values; those left at 0 are taken from the section.
void RailParameters::declare(input::Section& s) {
  std::vector<std::string_view> names;
  for (const RailSection& known : rail_sections()) names.push_back(known.name);
  s.text("section", section, "Rail section, which gives area, inertia and mass where these are 0.",
         names);
  s.choice("theory", theory, {"timoshenko", "euler"},
           "Beam theory of the rail; timoshenko: bending, shear and rotary inertia; euler: bending "
           "only (Euler-Bernoulli).");
  s.number("young", young, {.unit = "Pa", .above = 0, .usually_from = 1e9, .usually_to = 1e12},
           "Young's modulus of the rail.");
  s.number("poisson", poisson, {.above = -1, .at_most = 0.5},
           "Poisson's ratio of the rail, for the shear modulus.");
  s.number("shear_factor", shear_factor, {.above = 0, .at_most = 1},
           "Shear coefficient: effective shear area divided by area (timoshenko).");
  s.number("area", area, {.unit = "m2", .at_least = 0, .usually_from = 1e-4, .usually_to = 1},
           "Cross-sectional area of one rail; 0: that of the section.");
  s.number("inertia", inertia,
           {.unit = "m4", .at_least = 0, .usually_from = 1e-8, .usually_to = 10},
           "Second moment of area of one rail about its horizontal axis; 0: that of the section.");
  s.number("mass", mass, {.unit = "kg/m", .at_least = 0, .usually_from = 1, .usually_to = 1e5},
           "Mass per length of one rail; 0: that of the section.");
}

//   k G A = kappa A E/(2 (1 + nu)),   rho I = (m/A) I
Beam beam_of(const RailParameters& rail) {
  const RailSection& section = rail_section(rail.section);
  const double area = rail.area > 0 ? rail.area : section.area;
  const double inertia = rail.inertia > 0 ? rail.inertia : section.inertia;
  Beam beam;
  beam.bending_stiffness = rail.young * inertia;
  beam.mass = rail.mass > 0 ? rail.mass : section.mass;
  if (rail.theory == BeamTheory::euler) return beam;
  beam.shear_stiffness = rail.shear_factor * area * rail.young / (2 * (1 + rail.poisson));
  beam.rotary_inertia = beam.mass / area * inertia;
  return beam;
}

}  // namespace trackbed::track
