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

// The share of one corner of a zone in what acts on the borders of the model. `solid`: the zone's
// number, which says its size too.
struct Border {
  Border(const Mesh& mesh, const GroundParameters& parameters)
      : lattice_(mesh.lattice), solids_(mesh.solids), parameters_(parameters) {}

  // Whether a corner lies on a lateral border normal to a component, or on the base.
  bool on_side(const Index3& zone, int corner, int normal) const;
  bool on_base(const Index3& zone, int corner) const;
  double face(std::int32_t solid, int normal) const;                // m^2
  double dashpot(std::int32_t solid, int normal, int along) const;  // N s/m, Lysmer's
  double spring(std::int32_t solid) const;                          // N/m, below a quiet base

 private:
  const Lattice& lattice_;
  const Solids& solids_;
  const GroundParameters& parameters_;
};

// Local; computed anew in each run, not in checkpoints.
struct Terms {
  Terms(const Mesh& mesh, const GroundParameters& parameters, const Stiffness& stiffness);

  std::vector<double> mass;        // kg
  std::vector<double> carried;     // kg, whose weight the node carries; empty: its mass
  Nodal damping;                   // N s/m: dashpots and the mass part of Rayleigh damping
  std::vector<Spring> springs;     // below a quiet base, of held nodes too
  std::vector<std::uint8_t> held;  // bit c: component c cannot move
  // The same for the static start, where quiet borders give no support: a quiet base is held (or
  // rests on its springs), a quiet side is held along its normal.
  std::vector<std::uint8_t> held_at_rest;

  // N, of own weight, downwards.
  double weight(std::size_t node) const {
    return gravity * (carried.empty() ? mass[node] : carried[node]);
  }
  std::size_t bytes() const {
    return (mass.capacity() + carried.capacity()) * 8 + damping.bytes() +
           springs.capacity() * sizeof(Spring) + held.capacity() + held_at_rest.capacity();
  }

 private:
  void add_tetrahedra(const Mesh& mesh, const GroundParameters& parameters);
};

// What the quiet faces of a mesh file that look down are to a node, for a wave from below.
struct BasePart {
  std::int32_t node;
  double dashpots[3];  // N s/m
};
std::vector<BasePart> quiet_base(const Mesh& mesh);

// Impedances of a half space, Pa s/m (Lysmer, Kuhlemeyer 1969, doi:10.1061/JMCEA3.0001144).
struct Impedance {
  double normal, tangential;
};
Impedance impedance(const Elastic& solid, bool plane_stress);
// The springs of one node come from several zones: one entry each, in the order of nodes.
void merge(std::vector<Spring>& springs);

// Largest stable step of central differences without safety (s), over all ranks, and the zone that
// limits it. The largest frequency of the mesh is not above that of its stiffest zone standing
// alone (Fried 1972; Belytschko, Liu, Moran 2000, section 6.2); springs count as part of the zones
// above them. Stiffness-proportional damping, taken half a step late, lowers the step to 2/w
// (sqrt(1 + z^2) - z), z = rayleigh_stiffness w / 2. Mass-proportional damping and dashpots act on
// the mean velocity of a step and do not lower it.
double critical_step(const Mesh& mesh, const GroundParameters& parameters,
                     const Stiffness& stiffness, std::string& limit);
double critical_step_of_tetrahedra(const Mesh& mesh, const GroundParameters& parameters,
                                   const Stiffness& stiffness, std::string& limit);

}  // namespace trackbed::fem
