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
// wheelset. wheel: one wheelset alone. forces: axles of constant force. bogie: one bogie (bounce
// and pitch) on two wheelsets, below the mass that it carries (bounce).
// of_like: not said, that of `like`, or a coach; never of a vehicle that is complete.
enum class VehicleKind { coach, sprung, wheel, forces, bogie, of_like };

// A whole vehicle, both sides together; numbers of 0 are those of `like`.
struct VehicleParameters {
  std::string name = {};
  std::string like = {};  // a vehicle of the library
  VehicleKind kind = VehicleKind::of_like;
  double length = 0;                                        // m, between couplings
  double body_mass = 0, bogie_mass = 0, wheelset_mass = 0;  // kg
  double body_inertia = 0, bogie_inertia = 0;  // kg m^2, pitch; 0: of a uniform bar, see `complete`
  double primary_stiffness = 0, primary_damping = 0;      // N/m, N s/m, of one wheelset
  double secondary_stiffness = 0, secondary_damping = 0;  // N/m, N s/m, of one bogie
  double bogie_distance = 0, wheelbase = 0;               // m, between centres of bogies, of axles
  // On two rails: kg m^2, roll, 0: see `complete`; m, between the springs of both sides; m, of the
  // body's centre of mass, to the left.
  double body_roll = 0, bogie_roll = 0, wheelset_roll = 0;
  double primary_base = 0, secondary_base = 0;
  double body_offset = 0;
  std::vector<double> axles = {}, loads = {};  // forces: m behind the front, N of each axle
  std::string_view source = {};                // of the library's
  void declare(input::Section& s);
  void declare_masses(input::Section& s);
  void declare_springs(input::Section& s);
  void declare_roll(input::Section& s);
};

const std::vector<VehicleParameters>& vehicle_library();
// With everything `like` gives, and inertias of bars where none is given. What still lacks a number
// it needs is named in the second.
VehicleParameters complete(const VehicleParameters& given);
std::vector<std::string> lacking(const VehicleParameters& complete);
// Of `own` and of the library.
std::vector<std::string> vehicle_names(const std::vector<VehicleParameters>& own);
// Why there is no vehicle of that name, with the nearest one there is; empty if there is one.
std::string why_no_vehicle(const std::string& name, const std::vector<VehicleParameters>& own);

struct TrainParameters {
  std::vector<std::string> vehicles = {"manchester_1"};  // front first
  double speed = 50;                                     // m/s, where it is sent
  double start = 10;                                     // m, x of the first axle
  std::vector<double> times = {}, speeds = {};           // s since then, m/s; linear in between
  bool changes_are_clear() const;                        // times rise, each has its speed
  void declare(input::Section& s);
  void declare_changes(input::Section& s) const;
};

// Hz, undamped, of the vehicle with its wheelsets held, rising; with roll if it stands on two
// rails.
std::vector<double> natural_frequencies(const VehicleParameters& vehicle, bool rolls = false);

// Its share of one rail of `rails` alike, or the whole on two rails.
class Train {
 public:
  struct Wheel {
    double behind;           // m, behind the first axle
    std::int32_t unknown;    // of its wheelset's height; -1: constant force
    double force;            // N downwards on the rail, if constant
    double share;            // N, vehicle's weight per wheel: a first guess
    std::size_t axle = 0;    // its number in the train
    std::size_t side = 0;    // of two rails: left, right
    std::int32_t roll = -1;  // unknown of its wheelset's roll; -1: none
    double aside = 0;        // m, where it stands left of the wheelset's middle
  };
  // `known`: vehicles beside the library, which they come before. `gauge`, m: of two rails, which
  // take a left and a right wheel of each axle, left first; 0: one rail. Throws InputError for
  // unknown names.
  Train(const TrainParameters& parameters, const std::vector<VehicleParameters>& known,
        std::int64_t rails, double gauge = 0);

  const LinearSystem& system() const { return system_; }
  const Vector& weight() const { return weight_; }  // N on each unknown, upwards
  const std::vector<Wheel>& wheels() const { return wheels_; }
  const std::vector<VehicleParameters>& vehicles() const { return vehicles_; }
  // First unknown of each vehicle: body height (and pitch) come first.
  const std::vector<std::int32_t>& first_unknown() const { return first_; }
  // Of each vehicle's body (wheelset if it has none), -1: it does not roll.
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
