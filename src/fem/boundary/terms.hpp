// Nodal terms: lumped masses, dashpots and springs of the borders, fixed degrees of freedom; and
// the critical step that follows from elements and springs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "fem/kernel/stiffness.hpp"
#include "fem/mesh/mesh.hpp"

namespace trackbed::fem {

struct Spring {
  std::int32_t node;
  double stiffness;  // N/m, the same along every axis
};

// Contribution of one corner of an element to the border terms of the model. `solid`: the solid of
// the element, which also determines its size.
struct Border {
  Border(const Mesh& mesh, const GroundParameters& parameters)
      : lattice_(mesh.lattice), solids_(mesh.solids), parameters_(parameters) {}

  // Whether a corner is on a lateral border normal to a component, or on the base.
  bool on_side(const Index3& element, int corner, int normal) const;
  bool on_base(const Index3& element, int corner) const;
  double face(std::int32_t solid, int normal) const;                // m^2
  double dashpot(std::int32_t solid, int normal, int along) const;  // N s/m, Lysmer's
  double spring(std::int32_t solid) const;                          // N/m, below a viscous base

 private:
  const Lattice& lattice_;
  const Solids& solids_;
  const GroundParameters& parameters_;
};

// Local; computed in each run, not stored in checkpoints.
struct Terms {
  Terms(const Mesh& mesh, const GroundParameters& parameters, const Stiffness& stiffness);

  std::vector<double> mass;        // kg
  std::vector<double> carried;     // kg, for the weight on the node; empty: its mass
  Nodal damping;                   // N s/m: dashpots and the mass part of Rayleigh damping
  std::vector<Spring> springs;     // below a viscous base, of held nodes too
  std::vector<std::uint8_t> held;  // bit c: component c is fixed
  // The same for static equilibrium, where viscous borders give no support: a viscous base is held
  // (or supported by its springs), a viscous side is held along its normal.
  std::vector<std::uint8_t> held_static;

  // N, self weight, downwards.
  double weight(std::size_t node) const {
    return gravity * (carried.empty() ? mass[node] : carried[node]);
  }
  std::size_t bytes() const {
    return (mass.capacity() + carried.capacity()) * 8 + damping.bytes() +
           springs.capacity() * sizeof(Spring) + held.capacity() + held_static.capacity();
  }

 private:
  void add_tetrahedra(const Mesh& mesh, const GroundParameters& parameters);
};

// Dashpots at a node of viscous faces of a mesh file that face down, for a wave from below.
struct BasePart {
  std::int32_t node;
  double dashpots[3];  // N s/m
};
std::vector<BasePart> viscous_base(const Mesh& mesh);

// Impedances of a half space, Pa s/m (Lysmer, Kuhlemeyer 1969, doi:10.1061/JMCEA3.0001144).
struct Impedance {
  double normal, tangential;
};
Impedance impedance(const Elastic& solid, bool plane_stress);
// Merges the springs of a node from several elements: one entry per node, in the order of nodes.
void merge(std::vector<Spring>& springs);

// Largest stable step of central differences without safety factor (s), over all ranks, and the
// element that limits it. The largest frequency of the mesh is not above that of its stiffest free
// element (Fried 1972; Belytschko, Liu, Moran 2000, section 6.2); springs are included in the
// elements above them. Stiffness-proportional damping, which acts half a step late, reduces the
// step to 2/w (sqrt(1 + z^2) - z), z = rayleigh_stiffness w / 2. Mass-proportional damping and
// dashpots act on the mean velocity of a step and do not reduce it.
double critical_step(const Mesh& mesh, const GroundParameters& parameters,
                     const Stiffness& stiffness, std::string& limit);
double critical_step_of_tetrahedra(const Mesh& mesh, const GroundParameters& parameters,
                                   const Stiffness& stiffness, std::string& limit);

}  // namespace trackbed::fem
