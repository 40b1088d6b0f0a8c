// The library of vehicles and their parameters. Values are those of whole vehicles: values of a
// source for one spring, one side or half a train are multiplied here.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "trackbed/core/error.hpp"
#include "trackbed/core/types.hpp"
#include "trackbed/input/deck.hpp"
#include "trackbed/track/train.hpp"
#include "trackbed/track/vehicle_layout.hpp"

namespace trackbed::track {

namespace {

// One side: 1.22 MN/m and 4 kN s/m per axle box, 0.43 MN/m and 20 kN s/m secondary.
VehicleParameters manchester_1() {
  return {.name = "manchester_1",
          .length = 26,
          .body_mass = 32000,
          .bogie_mass = 2615,
          .wheelset_mass = 1813,
          .body_inertia = 1.97e6,
          .bogie_inertia = 1476,
          .primary_stiffness = 2.44e6,
          .primary_damping = 8e3,
          .secondary_stiffness = 0.86e6,
          .secondary_damping = 40e3,
          .bogie_distance = 19,
          .wheelbase = 2.56,
          .body_roll = 56800,
          .bogie_roll = 1722,
          .wheelset_roll = 1120,
          .source =
              "Manchester benchmarks, passenger vehicle 1 (Iwnicki 1998, "
              "doi:10.1080/00423119808969454); length assumed"};
}

// Two springs per axle and per bogie.
VehicleParameters alfa_pendular() {
  return {.name = "alfa_pendular",
          .length = 25.9,
          .body_mass = 36901,
          .bogie_mass = 4932,
          .wheelset_mass = 1800,
          .primary_stiffness = 2 * 564e3,
          .primary_damping = 2 * 18e3,
          .secondary_stiffness = 2 * 256.4e3,
          .secondary_damping = 2 * 35e3,
          .bogie_distance = 19,
          .wheelbase = 2.7,
          .source = "NeTIRail-INFRA D2.10, Table 1; inertias of uniform bars"};
}

// manchester_1 reduced to one bogie with axle loads of 15.5 t: (31000 - 2615 - 2 1340) kg on its
// secondary springs, wheelsets of 1340 kg, axles 2.9 m apart; roll inertia of the body from its
// mass.
VehicleParameters x2_bogie() {
  return {.name = "x2_bogie",
          .kind = VehicleKind::bogie,
          .length = 13,
          .body_mass = 25705,
          .bogie_mass = 2615,
          .wheelset_mass = 1340,
          .bogie_inertia = 1476,
          .primary_stiffness = 2.44e6,
          .primary_damping = 8e3,
          .secondary_stiffness = 0.86e6,
          .secondary_damping = 40e3,
          .wheelbase = 2.9,
          .bogie_roll = 1722,
          .source =
              "Model-based condition monitoring of railway switches and crossings, Table 4: "
              "wheelset, axle load, axle spacing; the rest of manchester_1; length assumed"};
}

// Given for half a wagon: axle load 22.5 t.
VehicleParameters freight_wagon() {
  return {.name = "freight_wagon",
          .length = 17,
          .body_mass = 81000,
          .bogie_mass = 1800,
          .wheelset_mass = 1400,
          .primary_stiffness = 2 * 2.6e6,
          .primary_damping = 2 * 1.5e4,
          .secondary_stiffness = 2 * 6e6,
          .secondary_damping = 2 * 6.5e4,
          .bogie_distance = 14,
          .wheelbase = 1.8,
          .source =
              "data of half a loaded wagon, doubled; inertias of "
              "uniform bars"};
}

// 25 t axles of one unit; masses and springs are not published with them.
VehicleParameters hxd1_unit() {
  constexpr double axle = 25e3 * gravity;  // N
  return {.name = "hxd1_unit",
          .kind = VehicleKind::forces,
          .length = 17.611,
          .axles = {2.9055, 5.7055, 11.9055, 14.7055},
          .loads = {axle, axle, axle, axle},
          .source = "axle positions and loads of one Bo'Bo' unit; constant forces"};
}

// Four axles, and 80 kN/m from 0.8 m beyond the outer ones, as forces 0.1 m apart, over 10 m.
VehicleParameters load_model_71() {
  VehicleParameters v{.name = "load_model_71",
                      .kind = VehicleKind::forces,
                      .length = 26.4,
                      .source = "EN 1991-2, 6.3.2; 10 m of 80 kN/m on each side"};
  constexpr double pitch = 0.1, around = 10, middle = 6.4;  // m
  for (int i = 0; i < 100; ++i) v.axles.push_back((i + 0.5) * pitch);
  v.loads.assign(100, 80e3 * pitch);
  for (int i = 0; i < 4; ++i) v.axles.push_back(around + 0.8 + 1.6 * i);
  v.loads.resize(104, 250e3);
  for (int i = 0; i < 100; ++i) v.axles.push_back(around + middle + (i + 0.5) * pitch);
  v.loads.resize(204, 80e3 * pitch);
  return v;
}

// m, radii of gyration in roll, of passenger vehicle 1 of the Manchester benchmarks; distance of
// springs across the track, from memory of the same.
constexpr double body_gyration = 1.33, bogie_gyration = 0.81, wheelset_gyration = 0.79;
constexpr double usual_base = 2.0;

// Values that may be taken from `like`.
constexpr double VehicleParameters::*numbers[] = {&VehicleParameters::length,
                                                  &VehicleParameters::body_mass,
                                                  &VehicleParameters::bogie_mass,
                                                  &VehicleParameters::wheelset_mass,
                                                  &VehicleParameters::body_inertia,
                                                  &VehicleParameters::bogie_inertia,
                                                  &VehicleParameters::primary_stiffness,
                                                  &VehicleParameters::primary_damping,
                                                  &VehicleParameters::secondary_stiffness,
                                                  &VehicleParameters::secondary_damping,
                                                  &VehicleParameters::bogie_distance,
                                                  &VehicleParameters::wheelbase,
                                                  &VehicleParameters::body_roll,
                                                  &VehicleParameters::bogie_roll,
                                                  &VehicleParameters::wheelset_roll,
                                                  &VehicleParameters::primary_base,
                                                  &VehicleParameters::secondary_base};

}  // namespace

// The order is that of the list of names in messages.
const std::vector<VehicleParameters>& vehicle_library() {
  static const std::vector<VehicleParameters> library = {
      manchester_1(), alfa_pendular(), x2_bogie(), freight_wagon(), hxd1_unit(), load_model_71()};
  return library;
}

// A bar of length L has m L^2/12. For the Manchester vehicle this is 0.92 and 0.97 of the measured
// inertias.
VehicleParameters complete(const VehicleParameters& given) {
  VehicleParameters v = given;
  for (const VehicleParameters& model : vehicle_library()) {
    if (given.like.empty() || model.name != given.like) continue;
    v.kind = model.kind;
    for (const auto number : numbers)
      if (v.*number == 0) v.*number = model.*number;
    if (v.axles.empty()) v.axles = model.axles;
    if (v.loads.empty()) v.loads = model.loads;
  }
  if (v.kind == VehicleKind::of_like) v.kind = VehicleKind::coach;
  if (v.body_inertia == 0) v.body_inertia = v.body_mass * v.length * v.length / 12;
  if (v.bogie_inertia == 0) v.bogie_inertia = v.bogie_mass * v.wheelbase * v.wheelbase / 12;
  const auto roll = [](double& inertia, double mass, double gyration) {
    if (inertia == 0) inertia = mass * gyration * gyration;
  };
  roll(v.body_roll, v.body_mass, body_gyration);
  roll(v.bogie_roll, v.bogie_mass, bogie_gyration);
  roll(v.wheelset_roll, v.wheelset_mass, wheelset_gyration);
  if (v.primary_base == 0) v.primary_base = usual_base;
  if (v.secondary_base == 0) v.secondary_base = usual_base;
  return v;
}

std::vector<std::string> vehicle_names(const std::vector<VehicleParameters>& own) {
  std::vector<std::string> names;
  for (const auto* list : {&own, &vehicle_library()})
    for (const VehicleParameters& vehicle : *list) names.push_back(vehicle.name);
  return names;
}

// The message suggests the nearest name: names of vehicles are long.
std::string why_no_vehicle(const std::string& name, const std::vector<VehicleParameters>& own) {
  const std::vector<std::string> names = vehicle_names(own);
  if (std::find(names.begin(), names.end(), name) != names.end()) return "";
  const std::string near = input::nearest(name, names);
  return fmt::format("there is no vehicle \"{}\"{}; there are {}", name,
                     near.empty() ? "" : fmt::format(" (did you mean {}?)", near),
                     fmt::join(names, ", "));
}

// Values that must not be 0: masses and springs without which the equations are singular. Dampers
// may be 0.
std::vector<std::string> lacking(const VehicleParameters& v) {
  std::vector<std::string> names;
  const auto need = [&](const char* name, bool there) {
    if (!there) names.emplace_back(name);
  };
  const VehicleLayout layout = layout_of(v.kind);
  const bool bogies = layout.bogies > 0;
  need("length", v.length > 0);
  if (layout.constant) {
    need("axles", !v.axles.empty());
    need("loads (one for each axle)", v.loads.size() == v.axles.size());
    return names;
  }
  need("wheelset_mass", v.wheelset_mass > 0);
  need("body_mass", v.body_mass > 0 || !layout.body);
  need("primary_stiffness", v.primary_stiffness > 0 || !layout.body);
  need("bogie_mass", v.bogie_mass > 0 || !bogies);
  need("secondary_stiffness", v.secondary_stiffness > 0 || !bogies);
  need("bogie_distance", v.bogie_distance > 0 || layout.bogies < 2);
  need("wheelbase", v.wheelbase > 0 || !bogies);
  return names;
}

namespace {

// Values used by vehicles of some kinds, besides the length.
using Has = bool (*)(const VehicleLayout&);
struct Usage {
  const char* name;
  double VehicleParameters::*number;
  Has by;
};
constexpr Has by_coach = [](const VehicleLayout& l) { return l.bogies > 1; };
constexpr Has by_pitch = [](const VehicleLayout& l) { return l.pitches; };
constexpr Has by_bogies = [](const VehicleLayout& l) { return l.bogies > 0; };
constexpr Has by_bodies = [](const VehicleLayout& l) { return l.body; };
constexpr Has by_wheels = [](const VehicleLayout& l) { return l.wheelsets > 0; };
using V = VehicleParameters;
constexpr Usage usages[] = {{"body_mass", &V::body_mass, by_bodies},
                            {"bogie_mass", &V::bogie_mass, by_bogies},
                            {"wheelset_mass", &V::wheelset_mass, by_wheels},
                            {"body_inertia", &V::body_inertia, by_pitch},
                            {"bogie_inertia", &V::bogie_inertia, by_bogies},
                            {"primary_stiffness", &V::primary_stiffness, by_bodies},
                            {"primary_damping", &V::primary_damping, by_bodies},
                            {"secondary_stiffness", &V::secondary_stiffness, by_bogies},
                            {"secondary_damping", &V::secondary_damping, by_bogies},
                            {"bogie_distance", &V::bogie_distance, by_coach},
                            {"wheelbase", &V::wheelbase, by_bogies},
                            {"body_roll", &V::body_roll, by_bodies},
                            {"bogie_roll", &V::bogie_roll, by_bogies},
                            {"wheelset_roll", &V::wheelset_roll, by_wheels},
                            {"primary_base", &V::primary_base, by_bodies},
                            {"secondary_base", &V::secondary_base, by_bogies},
                            {"body_offset", &V::body_offset, by_bodies}};

std::string kinds_with(Has property) {
  std::vector<std::string_view> found;
  const std::vector<std::string_view> kinds = vehicle_kinds();
  for (std::size_t k = 0; k < kinds.size(); ++k)
    if (!kinds[k].empty() && property(layout_of(static_cast<VehicleKind>(k))))
      found.push_back(kinds[k]);
  return fmt::format("{}", fmt::join(found, " or "));
}

// Errors for a vehicle that is like one of the library: its values in the deck would be taken as
// used. Warnings for other vehicles, whose kind may be changed on the command line.
void declare_unused(const V& given, const V& whole, input::Section& s) {
  const bool own = given.like.empty();
  const input::About about{.severity = own ? input::Severity::warning : input::Severity::problem};
  s.rule("kind", own || given.kind == VehicleKind::of_like || given.kind == whole.kind,
         fmt::format("must be \"{}\", that of the library vehicle {} (`like`); leave it out",
                     vehicle_kinds()[static_cast<std::size_t>(whole.kind)], given.like));
  const VehicleLayout layout = layout_of(whole.kind);
  for (const Usage& one : usages)
    s.rule(one.name, given.*one.number == 0 || one.by(layout),
           fmt::format("has no effect: it is for vehicles of kind {}", kinds_with(one.by)), about);
  const bool forces = layout.constant;
  s.rule("axles", given.axles.empty() || forces,
         "is only for vehicles of constant forces (kind = \"forces\")", about);
  s.rule("axles", std::is_sorted(given.axles.begin(), given.axles.end()),
         "must increase: the first axle is the foremost one");
  s.rule("loads", given.loads.empty() || forces,
         "is only for vehicles of constant forces (kind = \"forces\")", about);
  const double reach = axle_span_of(whole);
  s.rule("bogie_distance",
         layout.bogies < 2 || whole.bogie_distance == 0 || whole.bogie_distance > whole.wheelbase,
         fmt::format("must exceed the wheelbase of {:g} m: otherwise the bogies overlap; check "
                     "both (the wheelbase is that of one bogie)",
                     whole.wheelbase));
  s.rule(
      "length", reach <= whole.length,
      fmt::format("is less than the {:g} m that its axles need (wheelbase, bogie_distance): axles "
                  "overlap other vehicles",
                  reach),
      {.severity = input::Severity::warning});
}

}  // namespace

// These have no effect on a plane track.
void VehicleParameters::declare_roll(input::Section& s) {
  const auto inertia = [&](const char* of, double& value, const char* words) {
    s.number(of, value, {.unit = "kg m2", .at_least = 0}, words);
  };
  inertia(
      "body_roll", body_roll,
      "Roll inertia of the body about its centre of mass (on two rails); 0: mass * (1.33 m)^2.");
  inertia("bogie_roll", bogie_roll,
          "Roll inertia of one bogie (on two rails); 0: mass * (0.81 m)^2.");
  inertia("wheelset_roll", wheelset_roll,
          "Roll inertia of one wheelset (on two rails); 0: mass * (0.79 m)^2.");
  s.number("primary_base", primary_base, {.unit = "m", .at_least = 0, .usually_to = 3},
           "Lateral distance of left and right primary springs (on two rails), 0 or at least 0.01 "
           "m; 0: 2 m.");
  s.number("secondary_base", secondary_base, {.unit = "m", .at_least = 0, .usually_to = 3},
           "Lateral distance of left and right secondary springs (on two rails), 0 or at least "
           "0.01 m; 0: 2 m.");
  constexpr double narrow = 0.01;  // m; below it the springs give no roll stiffness
  for (const auto& [of, base] :
       {std::pair{"primary_base", primary_base}, std::pair{"secondary_base", secondary_base}})
    s.rule(of, base == 0 || base >= narrow, fmt::format("must be 0 or at least {:g} m", narrow),
           {.reads = {of}});
  s.number("body_offset", body_offset, {.unit = "m", .usually_from = -0.5, .usually_to = 0.5},
           "Lateral offset of the body's centre of mass to the left, as of a shifted load (on two "
           "rails).");
}

// A body of 81 t, a spring of 12 MN/m and a damper of 130 kN s/m are the largest of the library:
// values below the limits here are probably given in t, MN/m, kN/m or kN s/m.
void VehicleParameters::declare_masses(input::Section& s) {
  const auto mass = [&](const char* of, double& value, const char* words) {
    s.number(of, value, {.unit = "kg", .at_least = 0, .usually_from = 100, .usually_to = 2e5},
             words);
  };
  mass("body_mass", body_mass,
       "Mass of the body (coach, sprung), or of its part on the bogie (bogie).");
  mass("bogie_mass", bogie_mass, "Mass of one bogie without wheelsets (coach, bogie).");
  mass("wheelset_mass", wheelset_mass, "Mass of one wheelset.");
  s.number("body_inertia", body_inertia, {.unit = "kg m2", .at_least = 0},
           "Pitch inertia of the body (coach); 0: mass * length^2/12.");
  s.number("bogie_inertia", bogie_inertia, {.unit = "kg m2", .at_least = 0},
           "Pitch inertia of one bogie (coach, bogie); 0: mass * wheelbase^2/12.");
}

void VehicleParameters::declare_springs(input::Section& s) {
  const auto spring = [&](const char* of, double& value, const char* words) {
    s.number(of, value, {.unit = "N/m", .at_least = 0, .usually_from = 5e4, .usually_to = 1e9},
             words);
  };
  const auto damper = [&](const char* of, double& value, const char* words) {
    s.number(of, value, {.unit = "N s/m", .at_least = 0, .usually_from = 500, .usually_to = 1e7},
             words);
  };
  spring("primary_stiffness", primary_stiffness,
         "Stiffness of the primary suspension of one wheelset, both sides (coach, sprung, bogie).");
  damper("primary_damping", primary_damping,
         "Damping of the primary suspension of one wheelset, both sides (coach, sprung, bogie).");
  spring("secondary_stiffness", secondary_stiffness,
         "Stiffness of the secondary suspension of one bogie, both sides (coach, bogie).");
  damper("secondary_damping", secondary_damping,
         "Damping of the secondary suspension of one bogie, both sides (coach, bogie).");
}

// Values of 0 are taken from `like`, so that limits of a kind are checked on the completed vehicle.
void VehicleParameters::declare(input::Section& s) {
  std::vector<std::string_view> library = {""};
  for (const VehicleParameters& known : vehicle_library()) library.push_back(known.name);
  s.text("name", name, "Name by which the train refers to the vehicle.", {}, true);
  s.text("like", like,
         "Library vehicle from which the kind and every value not given here (or given as 0) are "
         "taken.",
         library);
  s.choice("kind", kind, vehicle_kinds(),
           "Kind of vehicle; coach: body, two bogies, four wheelsets; sprung: a mass on one "
           "wheelset; wheel: one wheelset; forces: constant forces of axles; bogie: one bogie, two "
           "wheelsets and the mass above; empty: that of `like`, or coach.");
  s.number("length", length, {.unit = "m", .at_least = 0, .usually_to = 100},
           "Length between couplings; axles are symmetric within it.");
  declare_masses(s), declare_springs(s);
  s.number("bogie_distance", bogie_distance, {.unit = "m", .at_least = 0, .usually_to = 50},
           "Distance between the bogie centres (coach).");
  s.number("wheelbase", wheelbase, {.unit = "m", .at_least = 0, .usually_to = 10},
           "Distance between the axles of a bogie (coach, bogie).");
  declare_roll(s);
  s.numbers("axles", axles, {.unit = "m", .at_least = 0},
            "Distances of the axles behind the vehicle's front (forces).");
  s.numbers("loads", loads, {.unit = "N", .at_least = 0, .usually_from = 500, .usually_to = 1e6},
            "Load of each axle, both wheels (forces).");
  declare_unused(*this, complete(*this), s);
  if (const auto missing = lacking(complete(*this)); !missing.empty())
    s.rule("kind", false, fmt::format("also needs {}", fmt::join(missing, ", ")));
}

// Names are checked where both lists are known (model/track_rules/track_model.cpp).
void TrainParameters::declare(input::Section& s) {
  s.texts("vehicles", vehicles,
          "Names of vehicles of the deck ([[vehicle]]) or of the library, front first. The list "
          "may be empty if there is a [[force]]; it must be empty with seat loads.");
  s.number("speed", speed, {.unit = "m/s", .at_least = 0, .usually_from = 1, .usually_to = 100},
           "Speed along x at the start, constant unless train.times are given; 0: the train stands "
           "at train.start for passage.duration.");
  s.number("start", start, {.unit = "m", .usually_from = -500, .usually_to = 2000},
           "x of the first axle at the start, from the start of the track. On a bed or a ground it "
           "must be given and be at most 0, on the rigid rail before the track.");
  s.numbers("times", times, {.unit = "s", .above = 0, .usually_to = 1000},
            "Times since the start at which train.speeds are reached; up to the last time the "
            "speed varies linearly; after it, the speed is constant.");
  s.numbers("speeds", speeds, {.unit = "m/s", .at_least = 0, .usually_from = 1, .usually_to = 100},
            "Speed at each of train.times; 0: the train stands. Longitudinal effects of braking on "
            "the vehicles are not modelled.");
  declare_changes(s);
}

bool TrainParameters::changes_are_valid() const {
  return times.size() == speeds.size() && (times.empty() || times.front() > 0) &&
         std::adjacent_find(times.begin(), times.end(), std::greater_equal<>()) == times.end();
}

// The last rule is evaluated for valid tables only.
void TrainParameters::declare_changes(input::Section& s) const {
  s.rule("times",
         std::adjacent_find(times.begin(), times.end(), std::greater_equal<>()) == times.end(),
         "must increase from each time to the next");
  s.rule("speeds", speeds.size() == times.size(),
         fmt::format("must be as many as train.times: {} speeds, {} times", speeds.size(),
                     times.size()));
  if (!changes_are_valid()) return;
  double largest = 0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const double change = speeds[i] - (i > 0 ? speeds[i - 1] : speed);
    const double lasts = times[i] - (i > 0 ? times[i - 1] : 0);
    largest = std::max(largest, std::abs(change) / lasts);
  }
  constexpr double emergency = 3;  // m/s^2, including magnetic track brakes
  s.rule(
      "speeds", largest <= emergency,
      fmt::format("require accelerations of up to {:.3g} m/s2 in magnitude; even emergency brakes "
                  "reach at most 3 m/s2",
                  largest),
      {.severity = input::Severity::warning, .reads = {"speed", "times", "speeds"}});
}

}  // namespace trackbed::track
