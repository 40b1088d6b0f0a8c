// Breakage. Corners of clumps: a small pebble that is loaded beyond its strength breaks off and
// becomes a stone of its own (Chen, Vinod, Indraratna, Ngo, Liu 2023,
// doi:10.1016/j.compgeo.2022.105105). Stones of polyhedra: they split in two, and their corners are
// crushed until their area bears the load.
#pragma once

#include <cstdint>
#include <string>

#include "trackbed/core/types.hpp"
#include "trackbed/dem/law.hpp"
#include "trackbed/input/section.hpp"

namespace trackbed::dem {

// A stone with corners splits if the octahedral shear stress of its contact forces,
//   q = sqrt((s1 - s2)^2 + (s2 - s3)^2 + (s3 - s1)^2)/3,  s = sum of force x arm over its volume,
// reaches its strength
//   strength (d/diameter)^(-3/weibull) [ln(1/P)]^(1/weibull),
// with the diameter d of the ball of its volume and P uniform in (0, 1): Weibull's law with its
// size effect. A ball between two platens has q = 0.9 F/d^2 (McDowell and de Bono 2013,
// doi:10.1680/geot.12.P.041).
struct SplittingParameters {
  double strength = 0;     // Pa, that 37 % of the stones of d = diameter survive; 0: none splits
  double diameter = 0.04;  // m
  double weibull = 3;
  void declare(input::Section& s);
  bool operator==(const SplittingParameters&) const = default;
};

// A corner of a polyhedron, where a contact with the force F is, is cut off by a plane across the
// contact's normal, so deep that its new face has the area F/strength, and becomes fines. Compare
// Harkness et al. 2016 (doi:10.1007/s10035-016-0660-y), whose contacts yield. The strength of each
// stone is drawn as above, without a size effect.
struct CuttingParameters {
  double strength = 0;  // Pa; 0: corners are not cut
  double weibull = 3;
  double least_depth = 0.01, largest_depth = 0.1;  // of a cut, over the diameter
  void declare(input::Section& s);
  bool operator==(const CuttingParameters&) const = default;
};

// Polyhedra wear: each stone of a contact loses the volume coefficient W/hardness (Archard 1953,
// doi:10.1063/1.1721448) as dust, with the work W of friction at its contacts. It becomes rounder
// and more compact (geom::worn).
struct WearParameters {
  double coefficient = 0;  // Archard's over the coefficient of friction; 0: no wear
  double hardness = 5e9;   // Pa
  double step = 2e-4;      // of a stone's volume, which is taken off at a time
  void declare(input::Section& s);
  bool operator==(const WearParameters&) const = default;
};

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
  SplittingParameters splitting;
  CuttingParameters cutting;
  WearParameters wear;
  std::int64_t check_steps = 100;  // sub-steps between checks of stones with corners
  void declare(input::Section& s);
  bool of_clumps() const { return strength > 0; }
  bool wears() const { return wear.coefficient > 0; }
  bool crushes() const { return splitting.strength > 0 || cutting.strength > 0; }
  bool of_corners() const { return crushes() || wears(); }
  bool any() const { return of_clumps() || of_corners(); }
  bool operator==(const BreakageParameters&) const = default;
};

// N, of a pebble of this diameter (m), number `pebble` of its unbroken stone.
double strength_of(const BreakageParameters& p, Id stone, std::int64_t pebble, double diameter);

// Pa, of a stone of this diameter (m); `splits`: how often it has split.
double splitting_strength(const BreakageParameters& p, Id stone, std::int64_t splits,
                          double diameter);
double cutting_strength(const BreakageParameters& p, Id stone);  // Pa

// kg, of the lightest fragment of this material; infinite without `least_size`.
double least_fragment(const BreakageParameters& p, const Material& material);

enum class BreakKind { pebble, cut, split, wear };

// What broke off: a pebble of a clump, the corner of a polyhedron, the smaller part of a split one,
// the dust of a worn one. What a split loses besides is a Break of its own, of fines.
struct Break {
  double time = 0;                // s, simulated since the particles exist
  Id stone = 0, fragment = -1;    // fragment -1: too small, it was removed as fines
  std::int64_t pebble = 0;        // of a clump
  Vec3 position = Vec3::Zero();   // m, centre of the fragment; of a corner that of its stone
  double diameter = 0, mass = 0;  // m, kg, of the fragment or of the fines; dust has no diameter
  double force = 0;               // N, of the contact that broke it, or of the largest one
  // J: elastic energy of the normal spring of that contact, of a split stone of all its contacts;
  // kinetic energy lost
  double released = 0, lost = 0;
  // Pa: of a split its octahedral shear stress, of a corner its strength
  double stress = 0;
  BreakKind kind = BreakKind::pebble;
};

// Sums over all ranks since the particles exist; bitwise identical for any number of ranks.
struct BreakTotals {
  std::int64_t fragments = 0, fines = 0;     // numbers; fines: of events that lose some
  std::int64_t cuts = 0, splits = 0;         // events of stones with corners
  double fragment_mass = 0, fines_mass = 0;  // kg; dust is part of the fines
  double released = 0, lost = 0;             // J, as in Break
  std::int64_t wears = 0;                    // events
  double dust_mass = 0;                      // kg
};

}  // namespace trackbed::dem
