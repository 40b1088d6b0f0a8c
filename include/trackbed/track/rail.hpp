// Rails: sections by name or by values, and the beam properties that follow from them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "trackbed/input/section.hpp"

namespace trackbed::track {

// One rail. `source` states the origin of each value.
struct RailSection {
  std::string_view name;
  double area, inertia, mass;  // m^2, m^4 about the horizontal axis, kg/m
  std::string_view source;
};
const std::vector<RailSection>& rail_sections();
// Throws InputError with the known names.
const RailSection& rail_section(std::string_view name);

// m, from foot to head of a 60E1 (EN 13674-1), by which pictures show the wheels above the
// sleepers; no result depends on it.
inline constexpr double drawn_rail_height = 0.172;

enum class BeamTheory { timoshenko, euler };

// Values of 0 are taken from the section.
struct RailParameters {
  std::string section = "60E1";
  BeamTheory theory = BeamTheory::timoshenko;
  double young = 210e9, poisson = 0.3;     // Pa, -
  double shear_factor = 0.4;               // -, kappa of k G A
  double area = 0, inertia = 0, mass = 0;  // m^2, m^4, kg/m
  void declare(input::Section& s);
};

// Properties used by the element. shear_stiffness and rotary_inertia are 0 for an Euler-Bernoulli
// beam, which means: rigid in shear, without rotary inertia.
struct Beam {
  double bending_stiffness = 0;  // N m^2, E I
  double shear_stiffness = 0;    // N, k G A
  double mass = 0;               // kg/m
  double rotary_inertia = 0;     // kg m, rho I
  Beam times(double factor) const {
    return {bending_stiffness * factor, shear_stiffness * factor, mass * factor,
            rotary_inertia * factor};
  }
};
Beam beam_of(const RailParameters& rail);

}  // namespace trackbed::track
