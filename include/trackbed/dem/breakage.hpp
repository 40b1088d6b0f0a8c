// Breakage of corners of clumps: a small pebble that is loaded beyond its strength breaks off and
// becomes a stone of its own (Chen, Vinod, Indraratna, Ngo, Liu 2023,
// doi:10.1016/j.compgeo.2022.105105).
#pragma once

#include <cstdint>
#include <string>

#include "trackbed/core/types.hpp"
#include "trackbed/dem/law.hpp"
#include "trackbed/input/section.hpp"

namespace trackbed::dem {

// Pebbles with a radius below `threshold` times the largest one of their stone may break off. Each
// has the strength
//   F = strength d^(2 + a) / diameter^a [ln(1/P)]^(1/weibull),  a = size_exponent,
// with its diameter d and a P that is uniform in (0, 1), drawn from the seed and the numbers of
// stone and pebble: the same on any number of ranks and in any later run.
struct BreakageParameters {
  std::string material = "ballast";  // of the stones that break
  std::string from;                  // stage from which on they break; none: the first under load
  double strength = 0;  // Pa, 0: nothing breaks; at d = diameter and a survival probability of 37 %
  double diameter = 0.018;  // m
  double size_exponent = 0.5;
  double weibull = 3.4;            // modulus
  double threshold = 0.5;          // of the largest radius
  double birth_size = 0.5;         // of a fragment, at most, of its final size
  std::int64_t growth_steps = 50;  // sub-steps for half of its final size, if there is space
  double growth_overlap = 1e-3;    // of its final radius: it waits while contacts have more
  double least_size = 0;           // m, diameter of fragments; 0: the lightest stone's mass
  std::int64_t seed = 1;
  void declare(input::Section& s);
};

// N, of a pebble of this diameter (m), number `pebble` of its unbroken stone.
double strength_of(const BreakageParameters& p, Id stone, std::int64_t pebble, double diameter);

// kg, of the lightest fragment of this material; infinite without `least_size`.
double least_fragment(const BreakageParameters& p, const Material& material);

// A pebble that broke off.
struct Break {
  double time = 0;              // s, simulated since the particles exist
  Id stone = 0, fragment = -1;  // fragment -1: too small, it was removed as fines
  std::int64_t pebble = 0;
  Vec3 position = Vec3::Zero();   // m, centre of the fragment
  double diameter = 0, mass = 0;  // m, kg, of the fragment or of the fines
  double force = 0;               // N, along the normal of the contact that broke it
  // J: elastic energy of the normal spring of that contact; kinetic energy lost
  double released = 0, lost = 0;
};

// Sums over all ranks since the particles exist; bitwise identical for any number of ranks.
struct BreakTotals {
  std::int64_t fragments = 0, fines = 0;     // numbers of pebbles
  double fragment_mass = 0, fines_mass = 0;  // kg
  double released = 0, lost = 0;             // J, as in Break
};

}  // namespace trackbed::dem
