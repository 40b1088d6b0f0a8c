// Vehicles as rigid bodies on springs and dampers, and trains of them: bounce and pitch, on two
// rails also roll.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "trackbed/input/section.hpp"
#include "trackbed/track/line.hpp"

namespace trackbed::track {

// coach: body and two bogies (bounce and pitch), four wheelsets. sprung: a mass on a spring on one
// wheelset. wheel: one wheelset. forces: axles of constant force. bogie: one bogie (bounce and
// pitch) on two wheelsets, below the mass that it carries (bounce).
// of_like, the last one: not given: that of `like`, or a coach; a completed vehicle never has it.
enum class VehicleKind { coach, sprung, wheel, forces, bogie, of_like };

// A whole vehicle, both sides together; values of 0 are taken from `like`.
struct VehicleParameters {
  std::string name = {};
  std::string like = {};  // a vehicle of the library
  VehicleKind kind = VehicleKind::of_like;
  double length = 0;                                        // m, between couplings
  double body_mass = 0, bogie_mass = 0, wheelset_mass = 0;  // kg
  double body_inertia = 0, bogie_inertia = 0;  // kg m^2, pitch; 0: uniform bar, see `complete`
  double primary_stiffness = 0, primary_damping = 0;      // N/m, N s/m, of one wheelset
  double secondary_stiffness = 0, secondary_damping = 0;  // N/m, N s/m, of one bogie
  double bogie_distance = 0, wheelbase = 0;               // m, between bogie centres, between axles
  // On two rails: kg m^2, roll, 0: see `complete`; m, between the springs of both sides; m, lateral
  // offset of the body's centre of mass to the left.
  double body_roll = 0, bogie_roll = 0, wheelset_roll = 0;
  double primary_base = 0, secondary_base = 0;
  double body_offset = 0;
  std::vector<double> axles = {}, loads = {};  // forces: m behind the front, N of each axle
  std::string_view source = {};                // reference of a library vehicle
  void declare(input::Section& s);
  void declare_masses(input::Section& s);
  void declare_springs(input::Section& s);
  void declare_roll(input::Section& s);
};

const std::vector<VehicleParameters>& vehicle_library();
// The vehicle with all values of `like`, and inertias of uniform bars where none is given;
// `lacking` returns the names of required values that are still missing.
VehicleParameters complete(const VehicleParameters& given);
std::vector<std::string> lacking(const VehicleParameters& complete);
// Names of `own` and of the library.
std::vector<std::string> vehicle_names(const std::vector<VehicleParameters>& own);
// Message that there is no vehicle of that name, with the nearest name; empty if there is one.
std::string why_no_vehicle(const std::string& name, const std::vector<VehicleParameters>& own);

struct TrainParameters {
  std::vector<std::string> vehicles = {"manchester_1"};  // front first
  double speed = 50;                                     // m/s, at the start
  double start = 10;                                     // m, x of the first axle at the start
  std::vector<double> times = {}, speeds = {};           // s since the start, m/s; linear between
  bool changes_are_valid() const;                        // times increase, each has a speed
  void declare(input::Section& s);
  void declare_changes(input::Section& s) const;
};

// Hz, undamped natural frequencies of the vehicle with fixed wheelsets, in ascending order; with
// roll on two rails.
std::vector<double> natural_frequencies(const VehicleParameters& vehicle, bool rolls = false);

// The part of the train carried by one of `rails` identical rails, or the whole train on two rails.
class Train {
 public:
  struct Wheel {
    double behind;           // m, behind the first axle
    std::int32_t unknown;    // of its wheelset's height; -1: constant force
    double force;            // N downwards on the rail, if constant
    double mean_load;        // N, vehicle's weight over its number of wheels: initial estimate
    std::size_t axle = 0;    // its number in the train
    std::size_t side = 0;    // of two rails: left, right
    std::int32_t roll = -1;  // unknown of its wheelset's roll; -1: none
    double aside = 0;        // m, to the left of the wheelset's middle
  };
  // `known`: vehicles in addition to the library, with priority over it. `gauge`, m: of two rails,
  // each axle then has a left and a right wheel, left first; 0: one rail. Throws InputError for
  // unknown names.
  Train(const TrainParameters& parameters, const std::vector<VehicleParameters>& known,
        std::int64_t rails, double gauge = 0);

  const LinearSystem& system() const { return system_; }
  const Vector& weight() const { return weight_; }  // N on each unknown, upwards
  const std::vector<Wheel>& wheels() const { return wheels_; }
  // N, the largest load of a wheel at rest on even track; 0 without wheels.
  double largest_static_load() const;
  const std::vector<VehicleParameters>& vehicles() const { return vehicles_; }
  // First unknown of each vehicle: body height (and pitch) come first.
  const std::vector<std::int32_t>& first_unknown() const { return first_; }
  // Roll unknown of each vehicle's body (wheelset if it has none), -1: it does not roll.
  const std::vector<std::int32_t>& roll_unknown() const { return roll_; }
  double axle_distance() const;  // m, first to last axle

 private:
  LinearSystem system_;
  Vector weight_;
  std::vector<Wheel> wheels_;
  std::vector<VehicleParameters> vehicles_;
  std::vector<std::int32_t> first_, roll_;
};

}  // namespace trackbed::track
