// Parameters of the track as a structure and of the run of a train over it, each declared once.
#include <fmt/format.h>

#include <cmath>

#include "trackbed/track/passage.hpp"

namespace trackbed::track {

namespace {

// Of lengths that are meant to be multiples, written with few digits.
constexpr double rounding = 1e-6;

bool is_multiple(double length, double of) {
  const double ratio = length / of;
  return ratio > 0.5 && std::abs(ratio - std::round(ratio)) < rounding * ratio;
}

}  // namespace

// Defaults are those of a medium pad under traffic; static values of a maker may be half.
void PadParameters::declare(input::Section& s) {
  s.number("stiffness", stiffness,
           {.unit = "N/m", .above = 0, .usually_from = 1e6, .usually_to = 1e10},
           "Of the pads on one rail seat.");
  s.number("damping", damping, {.unit = "N s/m", .at_least = 0, .usually_to = 1e6},
           "Of the pads on one rail seat.");
  s.number("knee", knee, {.unit = "m", .at_least = 0, .usually_to = 5e-3},
           "Compression at which a pad becomes stiffer; 0: it does not.");
  s.number("beyond", beyond, {.unit = "N/m", .at_least = 0, .usually_to = 1e10},
           "Stiffness beyond the knee.");
  s.flag(
      "uplift", uplift,
      "Whether the rail rises from sleepers once a pad has given back its preload; else pads pull "
      "without end (track alone).");
  s.number("preload", preload, {.unit = "N", .at_least = -1, .usually_to = 1e5},
           "What presses each pad at rest and is lifted first (uplift): the rail's weight and "
           "clips; below 0: the rail's weight.");
  s.rule("preload", uplift || preload < 0, "has no effect: pads pull without end (uplift = false)",
         {.weight = input::Weight::warning, .reads = {"uplift", "preload"}});
  s.rule("beyond", knee == 0 || beyond > stiffness, "must be above pad.stiffness",
         {.reads = {"stiffness", "knee", "beyond"}});
  s.rule("beyond", knee > 0 || beyond == 0, "has no effect without a knee",
         {.weight = input::Weight::warning, .reads = {"knee", "beyond"}});
  s.rule("damping", knee == 0 || damping > 0,
         "leaves pads with a knee without dampers: steps that pass it may gain energy",
         {.weight = input::Weight::warning, .reads = {"knee", "damping"}});
}

// One spring, or two with a mass between, for which Zhai, Wang and Lin (Modelling and experiment of
// railway ballast vibrations, 2004) give 137.75 MN/m, 58.8 kN s/m, 531.4 kg, 77.5 MN/m, 31.15 kN
// s/m.
void BallastParameters::declare(input::Section& s) {
  s.number("stiffness", stiffness,
           {.unit = "N/m", .above = 0, .usually_from = 1e6, .usually_to = 1e10},
           "Of the ballast below one rail seat.");
  s.number("damping", damping, {.unit = "N s/m", .at_least = 0, .usually_to = 1e7},
           "Of the ballast below one rail seat.");
  s.number("mass", mass, {.unit = "kg", .at_least = 0, .usually_to = 5000},
           "Of the ballast that moves with one rail seat; 0: none, and the ballast stands on rigid "
           "ground.");
  s.number("below_stiffness", below_stiffness, {.unit = "N/m", .above = 0},
           "Below the ballast mass.");
  s.number("below_damping", below_damping, {.unit = "N s/m", .at_least = 0},
           "Below the ballast mass.");
  const BallastParameters none;
  const input::About about{.weight = input::Weight::warning,
                           .reads = {"mass", "below_stiffness", "below_damping"}};
  s.rule("below_stiffness", mass > 0 || below_stiffness == none.below_stiffness,
         "has no effect without a mass of the ballast", about);
  s.rule("below_damping", mass > 0 || below_damping == none.below_damping,
         "has no effect without a mass of the ballast", about);
}

// Measured by their bedding modulus (N/mm^3, EN 16730): times the face of half a sleeper, about
// 0.35 m^2, 0.1 to 0.4 N/mm^3 are 35 to 140 MN/m.
void UnderSleeperPadParameters::declare(input::Section& s) {
  s.number("stiffness", stiffness,
           {.unit = "N/m", .at_least = 0, .usually_from = 5e6, .usually_to = 1e10},
           "Of the pad below a sleeper, for one rail seat, in series with the ballast; 0: none.");
  s.number("damping", damping, {.unit = "N s/m", .at_least = 0, .usually_to = 1e7},
           "Of the same, beside its spring.");
  s.number("from", from, {.unit = "m", .at_least = 0},
           "x from which sleepers have pads below them.");
  s.number("to", to, {.unit = "m", .at_least = 0},
           "x up to which; what stands right there has none. 0: all the others.");
  s.rule("to", to == 0 || to > from, "must lie beyond from, or be 0");
  const UnderSleeperPadParameters none;
  const input::About about{.weight = input::Weight::warning,
                           .reads = {"stiffness", "damping", "from", "to"}};
  const auto unused = [&](const char* name, double value, double unset) {
    s.rule(name, stiffness > 0 || value == unset, "has no effect without a stiffness of the pad",
           about);
  };
  unused("damping", damping, none.damping);
  unused("from", from, none.from), unused("to", to, none.to);
}

// A gap is worth more than a factor where ballast has been lost: the sleeper then strikes.
void TrackZone::declare(input::Section& s) {
  s.number("from", from, {.unit = "m", .required = true}, "x where the zone begins.");
  s.number("to", to, {.unit = "m", .required = true},
           "x where it ends: what stands right there is outside, but for the end of the track.");
  s.number("rail", rail, {.above = 0, .at_most = 1e9, .usually_to = 100},
           "Factor of the rail's bending and shear stiffness and mass, as in a crossing.");
  s.number("bed", bed, {.at_least = 0, .usually_to = 1000},
           "Factor of stiffness and damping of the bed, or of the ballast below sleepers.");
  s.number("gap", gap, {.unit = "m", .at_least = 0, .at_most = 100, .usually_to = 0.02},
           "Between sleepers and ballast while nothing is on the track: these sleepers hang.");
  s.choice("side", side, {"both", "left", "right"},
           "Rail, or end of the sleepers, that is so; of two.");
  s.rule("to", to > from, "must lie beyond from");
}

// What only a track with two rails has.
void TrackParameters::declare_space(input::Section& s) {
  s.choice(
      "dimension", dimension, {"plane", "space"},
      "plane: one rail with its share of vehicles and sleepers; space: two rails, sleepers and "
      "vehicles that roll as well.");
  s.number("gauge", gauge, {.unit = "m", .above = 0, .usually_from = 0.6, .usually_to = 2},
           "Between the middles of both rails (space, or sleepers that bend).");
  s.number("sleeper_length", sleeper_length,
           {.unit = "m", .above = 0, .usually_from = 0.5, .usually_to = 5},
           "Of sleepers, over which the ballast bears them evenly (space, or sleepers that bend).");
  s.number("sleeper_inertia", sleeper_inertia, {.unit = "kg m2", .at_least = 0},
           "Of a whole rigid sleeper in roll (space); 0: of a uniform bar.");
  s.rule("rails", dimension == Dimension::plane || rails == 2, "must be 2 where dimension = space",
         {.reads = {"dimension", "rails"}});
  for (std::size_t i = 0; i < zones.size(); ++i)
    s.rule(fmt::format("zone[{}].side", i),
           zones[i].side == ZoneSide::both || dimension == Dimension::space,
           "is for dimension = space", {.reads = {"dimension", "zone"}});
}

// With these values the first bending of a free sleeper of 2.6 m and 300 kg has 121 Hz; monoblock
// sleepers of concrete have 100 to 150 Hz.
void SleeperBeamParameters::declare(input::Section& s) {
  s.choice("model", model, {"rigid", "beam"},
           "beam: sleepers bend across the track; of a plane track the half of one, whose other "
           "half does the same.");
  s.choice("theory", theory, {"timoshenko", "euler"},
           "euler: rigid in shear, without rotary inertia (beam).");
  s.number("young", young, {.unit = "Pa", .above = 0, .usually_from = 1e9, .usually_to = 1e12},
           "Young's modulus (beam).");
  s.number("poisson", poisson, {.at_least = 0, .at_most = 0.5},
           "Poisson's ratio: shear modulus (beam, timoshenko).");
  s.number("width", width, {.unit = "m", .above = 0, .usually_from = 0.05, .usually_to = 0.6},
           "Of the rectangle that bends, alike all along (beam).");
  s.number("height", height, {.unit = "m", .above = 0, .usually_from = 0.05, .usually_to = 0.6},
           "The same (beam).");
  s.integer("elements", elements, {.at_least = 2, .at_most = 100},
            "Between the rails, an even number; beyond them they are at most as long (beam).");
  s.number("unsupported", unsupported, {.unit = "m", .at_least = 0, .usually_to = 2},
           "Of the middle, without ballast below; the rest carries as much more (space, or beam).");
  s.rule("elements", elements % 2 == 0, "must be even: the middle is a node");
}

// Mass and support of a sleeper that bends are spread along it.
void TrackParameters::declare_sleepers(input::Section& s) {
  const bool bends = sleeper.model == SleeperModel::beam;
  const input::About about{.reads = {"sleeper", "support", "dimension", "rails", "gauge",
                                     "sleeper_length", "sleeper_inertia"}};
  s.rule("sleeper.model", !bends || support == Support::sleepers,
         "must be rigid where there are none (support)", about);
  s.rule(
      "sleeper_length", !bends || sleeper_length > gauge,
      fmt::format("must be longer than the gauge of {:g} m: sleepers bend below the rails", gauge),
      about);
  s.rule("rails", !bends || rails == 2,
         "must be 2 with sleepers that bend: a plane track has half of each", about);
  s.rule("sleeper_inertia", !bends || sleeper_inertia == 0,
         "is for rigid sleepers: those that bend have their mass along them", about);
  s.rule("sleeper.unsupported", sleeper.unsupported < sleeper_length,
         fmt::format("must be shorter than the sleeper, which is {:g} m long", sleeper_length),
         about);
  s.rule("sleeper.unsupported", sleeper.unsupported == 0 || bends || dimension == Dimension::space,
         "has no effect on a plane track with rigid sleepers", about);
}

// Everything here is of one rail, except the sleeper: that is how drawings give it.
void TrackParameters::declare(input::Section& s) {
  s.choice(
      "support", support, {"sleepers", "continuous", "none"},
      "sleepers: pads, sleepers, ballast; continuous: a Kelvin bed right under the rail; none: "
      "held at its ends alone, as a bridge.");
  s.choice(
      "ends", ends, {"free", "pinned"},
      "Ends of the rail; pinned ones hold its height, so that it meets the rigid rails beyond.");
  s.integer("rails", rails, {.at_least = 1, .at_most = 2},
            "Rails alike that share vehicles and sleepers evenly; 1: a beam carries it all.");
  s.number("length", length, {.unit = "m", .above = 0, .usually_to = 2000},
           "Of the track, from x = 0; beyond it wheels roll on rigid rails.");
  s.number("spacing", spacing, {.unit = "m", .above = 0, .usually_from = 0.1, .usually_to = 30},
           "Of sleepers; the length is a multiple of it.");
  s.integer("elements", elements, {.at_least = 1, .at_most = 100}, "Of the rail in a spacing.");
  s.number("sleeper_mass", sleeper_mass,
           {.unit = "kg", .above = 0, .usually_from = 10, .usually_to = 2000},
           "Of a whole sleeper (sleepers).");
  s.number("bed_stiffness", bed_stiffness,
           {.unit = "N/m2", .above = 0, .usually_from = 1e5, .usually_to = 1e10},
           "Below one rail, per length (continuous).");
  s.number("bed_damping", bed_damping, {.unit = "N s/m2", .at_least = 0, .usually_to = 1e7},
           "Below one rail, per length (continuous).");
  s.number(
      "run_in", run_in, {.unit = "m", .at_least = 0, .usually_to = 50},
      "Length at both ends over which rail, pads and bed become stiffer towards the rigid rails "
      "beyond; of a rail without support (a bridge) there is none.");
  s.number("run_in_factor", run_in_factor, {.at_least = 1, .at_most = 1e6},
           "Stiffness and damping at the very ends over that of the track.");
  s.tables("zone", zones, "Where the track differs; factors of zones that overlap multiply.");
  s.table("sleeper", sleeper, "Sleepers across the track.");
  declare_space(s);
  declare_sleepers(s);
  s.rule("length", is_multiple(length, spacing), "must be a multiple of track.spacing",
         {.reads = {"length", "spacing"}});
  s.rule("ends", support != Support::none || ends == RailEnds::pinned,
         "must be pinned: the rail is held by nothing else");
  for (std::size_t i = 0; i < zones.size(); ++i)
    s.rule(fmt::format("zone[{}].gap", i), zones[i].gap == 0 || support == Support::sleepers,
           "is for sleepers that hang; there are none", {.reads = {"support", "zone"}});
  s.rule("run_in", support == Support::none || 2 * run_in <= length,
         "must be at most half the length");
}

// Wheel and rail swing against each other through their contact at several hundred Hz, together on
// the track at 50 to 100 Hz: 0.2 ms follows the second well and the first roughly.
void PassageParameters::declare(input::Section& s) {
  s.number("step", step, {.unit = "s", .above = 0, .usually_from = 1e-6, .usually_to = 1e-2},
           "Time step.");
  s.number("duration", duration, {.unit = "s", .at_least = 0, .usually_to = 1000},
           "Simulated time; 0: until the last axle has left the track.");
  s.choice(
      "loaded_by", loaded_by, {"train", "seats"},
      "train: wheels on the rail; seats: [load] on each rail seat, without pads and rail (of a "
      "track alone, or on a ground).");
  s.number("tolerance", tolerance,
           {.unit = "m", .at_least = 1e-20, .usually_from = 1e-16, .usually_to = 1e-8},
           "Of the approach of wheel and rail in each step; a stiffness of 1e9 N/m makes 1e-12 m "
           "1 mN.");
}

}  // namespace trackbed::track
