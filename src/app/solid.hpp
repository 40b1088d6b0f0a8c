// Sleepers and rails as solids: what the deck says of them, and the bodies that makes.
#pragma once

#include <vector>

#include "trackbed/fem/bodies.hpp"
#include "trackbed/input/section.hpp"

namespace trackbed::app {

struct Model;

// What rigid sleepers have no need of; extents and mass are those of the sleepers.
struct SolidParameters {
  double young = 37e9, poisson = 0.2;            // Pa, -, of sleepers
  double element = 0.1;                          // m, edge of elements, about
  double rayleigh_stiffness = 0;                 // s, of sleepers and rails
  double alpha = -0.1;                           // of Bossak's scheme
  bool half = false;                             // sleepers end at the middle of the track
  std::vector<double> seats = {0};               // m, y of rail seats from a sleeper's centre
  std::vector<double> seat_size = {0.15, 0.15};  // m, along x and y
  bool rails = false;                            // on pads on the seats, as solids
  double pad_shear = 0.3;                        // stiffness of pads along x and y over that of z
  void declare(input::Section& s);
};

// A rectangle with area and second moment of a rail, m.
struct RailBlock {
  double width, height;
};
RailBlock rail_block(const Model& model);

// Sleepers in turn, then a rail over each row of seats, from half a spacing before the first
// sleeper to half a spacing behind the last; z from the sleepers' lower face. Pads: of sleeper i
// and seat s number i * seats + s.
fem::BodiesParameters solid_bodies(const Model& model);
// The seat s of sleeper i; on rails as wide as they are.
fem::Patch seat_patch(const Model& model, std::size_t i, std::size_t s);

// kg, that a node of the lower face has under a force of short duration.
double solid_node_mass(const Model& model);

// What solids need, and what they do not take part in.
void declare_solids(const Model& model, input::Section& s);

}  // namespace trackbed::app
