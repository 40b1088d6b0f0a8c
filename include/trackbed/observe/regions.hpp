// Measurements of the stones in a region: porosity and density, contacts, and stress.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "trackbed/dem/particles.hpp"
#include "trackbed/input/section.hpp"
#include "trackbed/par/comm.hpp"

namespace trackbed::observe {

enum class RegionKind { box, sphere };

// A box cut into equal cells, or a sphere; in a plane model y is not used, and the sphere is a
// cylinder across the model.
struct Region {
  std::string name;
  RegionKind kind = RegionKind::box;
  std::vector<double> x = {0, 1}, y = {-0.5, 0.5}, z = {0, 0.3};  // m, box
  std::vector<double> cells = {1, 1, 1};                          // along x, y, z, box
  std::vector<double> centre = {0, 0, 0.15};                      // m, sphere
  double radius = 0.1;                                            // m, sphere
  void declare(input::Section& s);
};

// Components of symmetric tensors in the order xx yy zz xy xz yz.
using Tensor = std::array<double, 6>;

// Values of one cell; all zero except `porosity` (1) if there are no stones.
struct Measurement {
  double porosity = 1;       // volume fraction of voids; void ratio e = n/(1 - n)
  double bulk_density = 0;   // kg/m^3, mass of stones over volume of the cell
  double stones = 0;         // number of centres of mass in it
  double coordination = 0;   // mean number of stones and surfaces in contact with such a stone
  double contacts = 0;       // number of contacts whose branch midpoint is in it
  double contact_force = 0;  // N, mean magnitude
  // Of the stones with their centre in it: speed of the centre, m/s, and magnitude of the sum of
  // the contact forces on a stone, N. Mean, standard deviation over the stones (divisor: their
  // number), largest value. Rounding may hide deviations below about 1e-8 of the mean, or of N
  // stones below 1e-9 sqrt(N) of the largest value in the region.
  double speed = 0, speed_deviation = 0, largest_speed = 0;
  double stone_force = 0, stone_force_deviation = 0, largest_stone_force = 0;
  Tensor stress{};  // Pa, tension positive
  Tensor fabric{};  // mean n n^T of these contacts (Satake 1982); trace 1
};

inline constexpr int numbers_of_cell = sizeof(Measurement) / sizeof(double);

// The cells of the region, x fastest, then y. Bitwise identical on any number of ranks. Stones cut
// by a border are divided by points within them (dem::Particles::points), accurate to about a per
// cent of the stone. Stress: mean over the cell of the stress on straight lines of force between
// centres of mass (Love-Weber with the part of each branch that lies in the cell; Irving, Kirkwood
// 1950, doi:10.1063/1.1747782),
//   sigma = 1/V sum over contacts of f (x) l,
// f on the first stone, l the part of the branch from the first to the second (surface: to the
// contact point). In static equilibrium and without weight its mean over a slab is the force
// through any section of the slab over its area. Elastic forces only: damping forces and the
// momentum flux of moving stones are not included. Collective.
std::vector<Measurement> measure(const par::Comm& comm, const dem::Particles& particles,
                                 const Region& region);

}  // namespace trackbed::observe
