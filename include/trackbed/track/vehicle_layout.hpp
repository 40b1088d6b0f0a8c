// What a vehicle of each kind consists of. A kind without a layout does not compile. Also by kind:
// the names in VehicleParameters::declare (src/track/train/vehicles.cpp). Any number of bogies is
// possible, each with two axles: others need changes of `axles_of` and of `add_bogie`
// (src/track/train/train.cpp). The bogies of a vehicle are `bogie_distance` apart.
#pragma once

#include <vector>

#include "trackbed/track/train.hpp"

namespace trackbed::track {

struct VehicleLayout {
  bool constant = false;  // axles of constant force; nothing else
  bool body = false;      // a mass on springs
  bool pitches = false;   // the body does
  int bogies = 0;
  int wheelsets = 0;
};

VehicleLayout layout_of(VehicleKind kind);

// Of a completed vehicle: m behind its front; m, from its first to its last axle; kg, all of it.
std::vector<double> axles_of(const VehicleParameters& whole);
double axle_span_of(const VehicleParameters& whole);
double mass_of(const VehicleParameters& whole);

}  // namespace trackbed::track
