// What a vehicle of each kind consists of. A kind without a layout or without a name does not
// compile, nor does a layout that `Train` would not build correctly. Possible are
// - `constant`: axles of constant force, nothing else;
// - a wheelset without a body;
// - a body without bogies on one wheelset;
// - a body on any number of bogies, `bogie_distance` apart, each with two wheelsets.
// A body pitches on two or more bogies only: a single bogie or wheelset is below its centre and has
// no stiffness against pitch. Others need changes of
// - `layout_is_possible`, `axles_of`, `axle_span_of` and `mass_of` (vehicle_layout.cpp);
// - `add_bodies` and, in `Train::Train`, the first body's unknowns (`behind`) (train.cpp);
// - `complete` (vehicles.cpp) and `declare_tipping` (src/model/track_rules/track_model.cpp);
// - for a value of roll `declare_idle_vehicle` (src/model/track_rules/track_idle.cpp);
// - for vehicles joined to each other the loop in `Train::Train`: `add_bodies` sees one vehicle.
#pragma once

#include <string_view>
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
std::vector<std::string_view> vehicle_kinds();  // names in decks, in the order of VehicleKind

// Of a completed vehicle: m behind its front; m, from its first to its last axle; kg, all of it.
std::vector<double> axles_of(const VehicleParameters& whole);
double axle_span_of(const VehicleParameters& whole);
double mass_of(const VehicleParameters& whole);

}  // namespace trackbed::track
