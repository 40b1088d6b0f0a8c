// What acts node by node: lumped masses, dashpots and springs of the borders, held freedoms; and
// the critical step that follows from zones and springs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mesh.hpp"
#include "stiffness.hpp"

namespace trackbed::fem {

struct Spring {
  std::int32_t node;
  double stiffness;  // N/m, the same along every axis
};

// Local; computed anew in each run, not in checkpoints.
struct Terms {
  Terms(const Mesh& mesh, const GroundParameters& parameters, const Stiffness& stiffness);

  std::vector<double> mass;        // kg
  Nodal damping;                   // N s/m: dashpots and the mass part of Rayleigh damping
  std::vector<Spring> springs;     // below a quiet base, of held nodes too
  std::vector<std::uint8_t> held;  // bit c: component c cannot move
  // The same for the static start, where quiet borders give no support: a quiet base is held (or
  // rests on its springs), a quiet side is held along its normal.
  std::vector<std::uint8_t> held_at_rest;

  std::size_t bytes() const {
    return mass.capacity() * 8 + damping.bytes() + springs.capacity() * sizeof(Spring) +
           held.capacity() + held_at_rest.capacity();
  }
};

// Largest stable step of central differences without safety (s), over all ranks, and the zone that
// limits it. The largest frequency of the mesh is not above that of its stiffest zone standing
// alone (Fried 1972; Belytschko, Liu, Moran 2000, section 6.2); springs count as part of the zones
// above them. Stiffness-proportional damping, taken half a step late, lowers the step to 2/w
// (sqrt(1 + z^2) - z), z = rayleigh_stiffness w / 2. Mass-proportional damping and dashpots act on
// the mean velocity of a step and do not lower it.
double critical_step(const Mesh& mesh, const GroundParameters& parameters,
                     const Stiffness& stiffness, std::string& limit);

}  // namespace trackbed::fem
