// Parameters of sleepers and of the load on their rail seats, each declared once, together with
// their rules, which are checked with the line of the deck before anything is built.
#include <algorithm>
#include <array>
#include <set>

#include "trackbed/track/sleepers.hpp"

namespace trackbed::track {

namespace {

// A name given twice is refused: probably another one was intended.
bool are_degrees_of_freedom(const std::vector<std::string>& names) {
  constexpr std::array known{"x", "y", "z", "rx", "ry", "rz"};
  const bool valid = std::all_of(names.begin(), names.end(), [&](const std::string& name) {
    return std::find(known.begin(), known.end(), name) != known.end();
  });
  return valid && std::set(names.begin(), names.end()).size() == names.size();
}

}  // namespace

// Sleepers are identical and equally spaced; the density is that of the material.
void SleeperParameters::declare(input::Section& s) {
  auto fixed = s.fixed_by(input::state::sleepers);
  s.choice("model", model, {"rigid", "solid"},
           "Model of the sleepers; rigid: six degrees of freedom each; solid: elements, with rails "
           "or without ([solid]).");
  s.integer("count", count, {.at_least = 0, .at_most = 1e6}, "Number of sleepers.");
  s.number("first", first, {.unit = "m"}, "x of the centre of the first sleeper.");
  s.number("spacing", spacing, {.unit = "m", .above = 0, .usually_from = 0.2, .usually_to = 2},
           "Sleeper spacing, between centres.");
  s.number("y", y, {.unit = "m"},
           "y of the sleeper centres (3D models). Half track: y of the middle of the half "
           "sleepers.");
  s.number("width", width, {.unit = "m", .above = 0, .usually_to = 2}, "Sleeper width, along x.");
  s.number("height", height, {.unit = "m", .above = 0, .usually_to = 1},
           "Sleeper height, along z.");
  s.number("length", length, {.unit = "m", .above = 0, .usually_to = 10},
           "Sleeper length, along y (space; a plane model uses its thickness).");
  fixed.end();
  s.text("material", material, "Material of the sleepers, which defines density and contact laws.");
  s.texts("free", free,
          "Free degrees of freedom of the sleepers: any of x, y, z, rx, ry, rz. In a plane model "
          "only x, z and ry can be free.");
  const auto fixed_bevel = s.fixed_by(input::state::sleepers);
  s.number("bevel", bevel, {.unit = "m", .at_least = 0},
           "Bevel of the lower sleeper edges, at 45 degrees; 0: sharp edges.");
  s.rule("free", are_degrees_of_freedom(free),
         "may contain only x, y, z, rx, ry and rz, each at most once");
  s.rule("bevel", bevel < std::min(width / 2, height),
         fmt::format("must be below {:g} m (half the width) and below {:g} m (the height)",
                     width / 2, height));
  s.rule("spacing", count < 2 || spacing > width,
         fmt::format("must be larger than the width ({:g} m)", width));
}

double SeatLoadParameters::impact_factor() const {
  constexpr double growth = 5.21e-3, kmh = 3.6;  // growth: m h/km
  return wheel_diameter > 0 ? 1 + growth * kmh * speed / wheel_diameter : 1;
}

double SeatLoadParameters::dynamic_wheel_load() const { return impact_factor() * wheel_load; }
double SeatLoadParameters::largest_seat_load() const { return seat_share * dynamic_wheel_load(); }
double SeatLoadParameters::peak_load() const {
  return wheel_load > 0 ? slice * largest_seat_load() : peak;
}

// Each kind of load uses some of these; the brackets state which.
void SeatLoadParameters::declare(input::Section& s) {
  s.choice("kind", kind, {"winkler", "power", "table", "seats"},
           "Seat loads; winkler: distributed along the track like the deflection of a beam on a "
           "Winkler foundation; power: ratio^((s/spacing)^2) at the distance s from an axle; "
           "table: one history for all sleepers; seats: a history for each.");
  s.number("peak", peak, {.unit = "N", .at_least = 0, .usually_from = 1e3, .usually_to = 1e6},
           "Seat load of one axle directly above the sleeper (winkler, power). A wheel load Q on a "
           "beam on a Winkler foundation gives peak = Q * decay * spacing / 2.");
  s.number("speed", speed, {.unit = "m/s", .above = 0, .usually_from = 0.1, .usually_to = 98},
           "Speed of the axles along x.");
  s.numbers("axles", axles, {.unit = "m", .at_least = 0, .usually_to = 500},
            "Distance of each axle behind the first, for example [0, 2.8] for a bogie (winkler, "
            "power).");
  s.number("start", start, {.unit = "m"},
           "x of the first axle at the start of the passage (winkler, power).");
  s.number("decay", decay, {.unit = "1/m", .above = 0, .usually_from = 0.1, .usually_to = 10},
           "Decay b of the load exp(-b|s|) (cos b|s| + sin b|s|) at the distance s from an axle "
           "(winkler): b = (k / 4 E I)^(1/4), with E I of one rail and k, in Pa, the stiffness "
           "below a seat divided by the spacing.");
  s.number("ratio", ratio, {.above = 0},
           "Ratio of the load one sleeper spacing from the axle to the peak load (power).");
  s.file("file", file,
         "CSV of seat loads; table: columns time_s and force_N, the load of the sleeper at x = 0; "
         "at the sleeper at position x it acts with a delay of x/speed; seats: columns time_s, "
         "sleeper_0, sleeper_1 and so on, in N. Loads are linear between rows, 0 before the first "
         "and after the last.");
  s.number("gauge", gauge, {.unit = "m", .at_least = 0, .usually_to = 2},
           "Distance between the two seats of a sleeper, each with a column: sleeper_0_left, "
           "sleeper_0_right and so on (seats, on a three-dimensional bed); 0: one seat in the "
           "middle.");
  s.number("wheel_load", wheel_load,
           {.unit = "N", .at_least = 0, .usually_from = 1e4, .usually_to = 3e5},
           "Static load of a wheel, half of an axle load, from which the seat load of one axle is "
           "computed instead of `peak`: slice * seat_share * wheel_load * (1 + 5.21e-3 v/D), "
           "with v in km/h and the wheel diameter D in m (winkler, power); 0: `peak` is given.");
  s.number("wheel_diameter", wheel_diameter,
           {.unit = "m", .at_least = 0, .usually_from = 0.3, .usually_to = 1.5},
           "Wheel diameter D, for wheel_load; 0: the wheel load does not grow with the speed.");
  s.number(
      "seat_share", seat_share, {.above = 0, .at_most = 1},
      "Part of the wheel load that the seat directly below the wheel carries, for wheel_load.");
  s.number("slice", slice, {.above = 0, .at_most = 10},
           "Ratio of the load on a sleeper of the model to that of a rail seat, for wheel_load: 1 "
           "for half a track; for a slice its width divided by the effective length of the "
           "sleeper below a seat.");
  s.rule("ratio", ratio < 1, "must be below 1");
  s.rule(
      "wheel_load", wheel_load == 0 || !is_table(),
      "has no effect on a table of seat loads; remove it, or give kind = \"winkler\" or \"power\"");
  s.rule("wheel_load",
         wheel_load > 0 || (wheel_diameter == 0 && seat_share == SeatLoadParameters{}.seat_share &&
                            slice == SeatLoadParameters{}.slice),
         "wheel_diameter, seat_share and slice have no effect without a wheel load",
         {.severity = input::Severity::warning});
  s.rule("gauge", gauge == 0 || kind == SeatLoadKind::seats,
         "needs kind = \"seats\", whose table has columns of both seats");
  s.rule("file", !is_table() || !file.empty(), "is needed for kind = \"table\" and \"seats\"");
}

}  // namespace trackbed::track
