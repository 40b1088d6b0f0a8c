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
  s.choice("model", model, {"rigid", "solid"},
           "rigid: six degrees of freedom each; solid: elements, with rails or without ([solid]).");
  s.integer("count", count, {.at_least = 0}, "Number of sleepers.");
  s.number("first", first, {.unit = "m"}, "x of the centre of the first sleeper.");
  s.number("spacing", spacing, {.unit = "m", .above = 0, .usually_from = 0.2, .usually_to = 2},
           "Distance between centres.");
  s.number("y", y, {.unit = "m"},
           "y of the centres (space): half a track has half sleepers, centred between its wall and "
           "their ends.");
  s.number("width", width, {.unit = "m", .above = 0, .usually_to = 2}, "Extent along x.");
  s.number("height", height, {.unit = "m", .above = 0, .usually_to = 1}, "Extent along z.");
  s.number("length", length, {.unit = "m", .above = 0, .usually_to = 10},
           "Extent along y in space; in a plane model the thickness of the model counts.");
  s.text("material", material, "Material, which gives the density and the contact laws.");
  s.texts("free", free,
          "Free degrees of freedom: x, y, z, rx, ry, rz. In a plane model only x, z and ry can be "
          "free.");
  s.number("bevel", bevel, {.unit = "m", .at_least = 0},
           "Bevel of the lower edges at 45 degrees; 0: sharp edges.");
  s.rule("free", are_degrees_of_freedom(free),
         "must name each of x, y, z, rx, ry, rz at most once");
  s.rule("bevel", bevel < std::min(width / 2, height),
         "must be smaller than half the width and than the height");
  s.rule("spacing", count < 2 || spacing > width, "must be larger than the width");
}

// Each kind of load uses some of these; the brackets state which.
void SeatLoadParameters::declare(input::Section& s) {
  s.choice("kind", kind, {"winkler", "power", "table", "seats"},
           "Shape of the load of one axle along the track: deflection of a beam on a Winkler bed, "
           "ratio^((s/spacing)^2), a measured history, or a history for each sleeper.");
  s.number("peak", peak, {.unit = "N", .at_least = 0, .usually_from = 1e3, .usually_to = 1e6},
           "Rail-seat load of one axle directly above the sleeper (winkler, power). For a wheel "
           "load Q on a beam on a Winkler bed: Q decay spacing / 2.");
  s.number("speed", speed, {.unit = "m/s", .above = 0, .usually_from = 0.1, .usually_to = 98},
           "Speed of the axles along x.");
  s.numbers("axles", axles, {.unit = "m", .at_least = 0, .usually_to = 500},
            "Distance of each axle behind the first (winkler, power).");
  s.number("start", start, {.unit = "m"},
           "x of the first axle at the start of the passage (winkler, power).");
  s.number(
      "decay", decay, {.unit = "1/m", .above = 0, .usually_from = 0.1, .usually_to = 10},
      "b in the load exp(-b|s|) (cos b|s| + sin b|s|) at a distance s from the axle (winkler): "
      "(k / 4 E I)^(1/4) of a rail E I on a bed of k Pa, which is a seat's stiffness over the "
      "spacing.");
  s.number("ratio", ratio, {.above = 0}, "Load one sleeper away over the peak (power).");
  s.file("file", file,
         "CSV with columns time_s, force_N: load on the sleeper at x = 0, delayed by x/speed at "
         "others (table); with time_s, sleeper_0, sleeper_1 and so on, N: of each sleeper (seats). "
         "Linear between rows, 0 before the first and after the last.");
  s.number(
      "gauge", gauge, {.unit = "m", .at_least = 0, .usually_to = 2},
      "Between the two seats of a sleeper of a bed in space, each with a column: sleeper_0_left, "
      "sleeper_0_right and so on (seats); 0: one seat in its middle.");
  s.rule("axles", is_table() || !axles.empty(), "must name at least one axle");
  s.rule("ratio", ratio < 1, "must be below 1");
  s.rule("gauge", gauge == 0 || kind == SeatLoadKind::seats,
         "needs kind = \"seats\", whose table has columns of both seats");
  s.rule("file", !is_table() || !file.empty(), "is needed for kind = \"table\" and \"seats\"");
}

}  // namespace trackbed::track
