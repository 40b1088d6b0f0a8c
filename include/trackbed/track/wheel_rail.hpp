// Wheel-rail contact: Hertzian contact from radii, and wheel flats.
#pragma once

#include <cstdint>

#include "trackbed/input/section.hpp"

namespace trackbed::track {

// Two elastic bodies whose principal curvatures lie in the same planes: a wheel (rolling radius,
// conical tread) on a rail head (its radius across the track).
struct HertzBodies {
  double wheel_radius = 0.46, rail_radius = 0.30;  // m
  double young = 210e9, poisson = 0.3;             // Pa, -, both bodies
};

// Elliptic contact at normal force F (N): approach = (F/constant)^(2/3).
struct HertzContact {
  double constant = 0;                  // N/m^1.5
  double half_axis_a = 0;               // m/N^(1/3), times F^(1/3): the major one
  double half_axis_b = 0;               // m/N^(1/3)
  double pressure(double force) const;  // Pa, maximum
};
HertzContact hertz_contact(const HertzBodies& bodies);

enum class WheelRailLaw { hertz, linear };

struct WheelRailParameters {
  WheelRailLaw law = WheelRailLaw::hertz;
  HertzBodies bodies;
  double constant = 0;         // N/m^1.5; 0: from the bodies
  double stiffness = 1.3e9;    // N/m, linear
  std::int64_t flat_axle = 0;  // axle whose wheels have a flat, the first is 1; 0: none
  double flat_length = 0.05;   // m
  double flat_at = 0;          // m, x where its middle touches the rail, again after each turn
  void declare(input::Section& s);
};

// Force on a wheel as a function of its approach to the rail; zero without contact. Pure function.
class WheelRail {
 public:
  explicit WheelRail(const WheelRailParameters& parameters);
  double force(double approach) const;  // N
  double slope(double approach) const;  // N/m
  double approach(double force) const;  // m
  // m, lowering of the wheel of axle number `axle` (from 0) at x by its flat.
  double flat(std::size_t axle, double x) const;
  double constant() const { return constant_; }

 private:
  WheelRailLaw law_;
  double constant_;  // N/m^1.5, linear: N/m
  std::int64_t flat_axle_;
  double flat_length_, flat_at_, radius_;  // m
};

}  // namespace trackbed::track
