// Sleepers and rails as solids: their parameters, and the bodies made of them.
#pragma once

#include <vector>

#include "trackbed/fem/bodies.hpp"
#include "trackbed/input/section.hpp"

namespace trackbed::model {

struct Model;

// Parameters that rigid sleepers do not have; extents and mass are those of [sleepers].
struct SolidParameters {
  double young = 37e9, poisson = 0.2;            // Pa, -, of sleepers
  double element = 0.1;                          // m, approximate edge of elements
  double rayleigh_stiffness = 0;                 // s, of sleepers and rails
  double alpha = -0.1;                           // parameter of Bossak's scheme
  bool half = false;                             // sleepers end at the middle of the track
  std::vector<double> seats = {0};               // m, y of rail seats from a sleeper's centre
  std::vector<double> seat_size = {0.15, 0.15};  // m, along x and y
  bool rails = false;                            // on pads on the seats, as solids
  double pad_shear = 0.3;  // stiffness of pads along x and y over that along z
  void declare(input::Section& s);
};

// A rectangle with the area and second moment of a rail, m.
struct RailBlock {
  double width, height;
};
RailBlock rail_block(const Model& model);

// Sleepers in order, then a rail over each row of seats, from half a spacing before the first
// sleeper to half a spacing behind the last; z from the sleepers' lower face. The pad of sleeper i
// and seat s has the number i * seats + s.
fem::BodiesParameters solid_bodies(const Model& model);
// The seat s of sleeper i; below solid rails as wide as the rail.
fem::Patch seat_patch(const Model& model, std::size_t i, std::size_t s);

// kg, effective mass of a node of the lower face under a force of short duration.
double solid_node_mass(const Model& model);

// Rules of solids: what they need, and what they cannot be combined with.
void declare_solids(const Model& model, input::Section& s);

}  // namespace trackbed::model
