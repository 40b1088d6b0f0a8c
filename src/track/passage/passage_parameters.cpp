// Parameters of the track as a structure and of the run of a train over it, each declared once.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "trackbed/track/passage.hpp"

namespace trackbed::track {

namespace {

// Relative, of lengths that should be multiples but are written with few digits.
constexpr double whole_multiple = 1e-6;

constexpr double border = 1e-9;  // m, rounding of borders of zones

bool is_multiple(double length, double of) {
  const double ratio = length / of;
  return ratio > 0.5 && std::abs(ratio - std::round(ratio)) < whole_multiple * ratio;
}

// Of rail pads and ballast: our decks have 25e3 N s/m and more, which in kN s/m is below this.
void declare_small_damping(double damping, input::Section& s) {
  constexpr double usual = 100;  // N s/m
  s.rule("damping", damping == 0 || damping >= usual,
         fmt::format("is small: usually at least {:g} N s/m; is it meant in kN s/m?", usual),
         {.severity = input::Severity::warning, .reads = {"damping"}});
}

}  // namespace

// Defaults are those of a medium pad under traffic; static values of a manufacturer may be half.
void PadParameters::declare(input::Section& s) {
  auto fixed = s.fixed_by(input::state::solid_rails);
  s.number("stiffness", stiffness,
           {.unit = "N/m", .above = 0, .usually_from = 1e7, .usually_to = 1e10},
           "Stiffness of the rail pads at one rail seat.");
  fixed.end();
  s.number("damping", damping, {.unit = "N s/m", .at_least = 0, .usually_to = 1e6},
           "Damping of the rail pads at one rail seat.");
  const auto fixed_shape = s.fixed_by(input::state::solid_rails);
  s.number("bilinear_at", bilinear_at, {.unit = "m", .at_least = 0, .usually_to = 5e-3},
           "Compression beyond which `bilinear_stiffness` applies; 0: pads are linear.");
  s.number("bilinear_stiffness", bilinear_stiffness,
           {.unit = "N/m", .at_least = 0, .usually_to = 1e10},
           "Tangent stiffness of the rail pads beyond `bilinear_at`.");
  s.flag("uplift", uplift,
         "Whether the rail lifts off a pad that has lost its preload (track alone); otherwise pads "
         "transmit unlimited tension.");
  s.number("preload", preload, {.unit = "N", .at_least = -1, .usually_to = 1e5},
           "Static compressive force of each pad from rail weight and fastenings (uplift); below "
           "0: the rail's weight alone.");
  s.rule("preload", uplift || preload < 0,
         "has no effect: the rail does not lift off its pads (uplift = false)",
         {.severity = input::Severity::warning, .reads = {"uplift", "preload"}});
  s.rule("bilinear_stiffness", bilinear_at == 0 || bilinear_stiffness > stiffness,
         fmt::format("must be above pad.stiffness ({:g} N/m)", stiffness),
         {.reads = {"stiffness", "bilinear_at", "bilinear_stiffness"}});
  s.rule("bilinear_stiffness", bilinear_at > 0 || bilinear_stiffness == 0,
         "has no effect with bilinear_at = 0",
         {.severity = input::Severity::warning, .reads = {"bilinear_at", "bilinear_stiffness"}});
  declare_small_damping(damping, s);
  s.rule("damping", bilinear_at == 0 || damping > 0,
         "leaves bilinear pads undamped: energy may increase in steps in which the compression "
         "passes bilinear_at",
         {.severity = input::Severity::warning, .reads = {"bilinear_at", "damping"}});
}

// One spring, or two with a mass between, for which Zhai, Wang and Lin (Modelling and experiment of
// railway ballast vibrations, 2004) give 137.75 MN/m, 58.8 kN s/m, 531.4 kg, 77.5 MN/m, 31.15 kN
// s/m.
void BallastParameters::declare(input::Section& s) {
  s.number("stiffness", stiffness,
           {.unit = "N/m", .above = 0, .usually_from = 1e6, .usually_to = 1e10},
           "Stiffness of the ballast below one rail seat.");
  s.number("damping", damping, {.unit = "N s/m", .at_least = 0, .usually_to = 1e7},
           "Damping of the ballast below one rail seat.");
  declare_small_damping(damping, s);
  s.number("mass", mass, {.unit = "kg", .at_least = 0, .usually_to = 5000},
           "Vibrating mass of the ballast below one rail seat; 0: massless ballast without a "
           "second spring.");
  s.number("below_stiffness", below_stiffness, {.unit = "N/m", .above = 0},
           "Stiffness of the spring below the ballast mass.");
  s.number("below_damping", below_damping, {.unit = "N s/m", .at_least = 0},
           "Damping of the spring below the ballast mass.");
  const BallastParameters none;
  const input::About about{.severity = input::Severity::warning,
                           .reads = {"mass", "below_stiffness", "below_damping"}};
  s.rule("below_stiffness", mass > 0 || below_stiffness == none.below_stiffness,
         "has no effect without a mass of the ballast (mass)", about);
  s.rule("below_damping", mass > 0 || below_damping == none.below_damping,
         "has no effect without a mass of the ballast (mass)", about);
}

// Measured by their bedding modulus (N/mm^3, EN 16730): times the face of half a sleeper, about
// 0.35 m^2, 0.1 to 0.4 N/mm^3 are 35 to 140 MN/m.
void UnderSleeperPadParameters::declare(input::Section& s) {
  s.number("stiffness", stiffness,
           {.unit = "N/m", .at_least = 0, .usually_from = 5e6, .usually_to = 1e10},
           "Stiffness of the under-sleeper pad at one rail seat, in series with the ballast; 0: no "
           "pad.");
  s.number("damping", damping, {.unit = "N s/m", .at_least = 0, .usually_to = 1e7},
           "Damping of the under-sleeper pad, in parallel with its stiffness.");
  s.number("from", from, {.unit = "m", .at_least = 0},
           "x from which sleepers have under-sleeper pads.");
  s.number(
      "to", to, {.unit = "m", .at_least = 0},
      "x up to which sleepers have under-sleeper pads (exclusive); 0: up to the end of the track.");
  s.rule("to", to == 0 || to > from,
         fmt::format("must be above `from`, or 0 (from = {:g} m)", from));
  const UnderSleeperPadParameters none;
  const input::About about{.severity = input::Severity::warning,
                           .reads = {"stiffness", "damping", "from", "to"}};
  const auto unused = [&](const char* name, double value, double unset) {
    s.rule(name, stiffness > 0 || value == unset,
           "has no effect without a stiffness of the pad (stiffness)", about);
  };
  unused("damping", damping, none.damping);
  unused("from", from, none.from), unused("to", to, none.to);
}

// Where ballast is missing, a gap is more realistic than a factor: the sleeper strikes the ballast.
void TrackZone::declare(input::Section& s) {
  s.number("from", from, {.unit = "m", .required = true}, "x at the start of the zone.");
  s.number("to", to, {.unit = "m", .required = true},
           "x at the end of the zone (exclusive, except at the end of the track).");
  s.number("rail", rail, {.above = 0, .at_most = 1e9, .usually_to = 100},
           "Factor on bending stiffness, shear stiffness and mass of the rail, as in a crossing.");
  s.number("bed", bed, {.at_least = 0, .usually_to = 1000},
           "Factor on stiffness and damping of the support: the continuous (Winkler) bed, or the "
           "ballast springs below sleepers.");
  s.number("pad", pad, {.above = 0, .at_most = 1e6, .usually_to = 100},
           "Factor on stiffness (also bilinear_stiffness) and damping of the rail pads: soft or "
           "stiff fastenings; bilinear_at and preload do not change.");
  s.number("sleeper", sleeper, {.above = 0, .at_most = 1e6, .usually_to = 20},
           "Factor on mass and roll inertia of whole sleepers on springs.");
  s.number("under_sleeper_pad", under_sleeper_pad, {.above = 0, .at_most = 1e6, .usually_to = 100},
           "Factor on stiffness and damping of the under-sleeper pads.");
  s.number(
      "footprint", footprint, {.at_least = 0.01, .at_most = 1000, .usually_to = 4},
      "Factor on the width (along the track) of the footprints of sleepers on a ground: wider "
      "or narrower sleepers. The ballast spring does not change with it; for that give `bed`.");
  s.number("spacing", spacing, {.unit = "m", .at_least = 0, .usually_from = 0.1, .usually_to = 30},
           "Sleeper spacing in the zone, which begins and ends with a sleeper: its length must be "
           "a multiple of it; 0: that of the track. The last sleeper is not part of the zone and "
           "does not have its factors (see `to`). Without sleepers it only changes the length of "
           "the rail's elements.");
  s.number("gap", gap, {.unit = "m", .at_least = 0, .at_most = 100, .usually_to = 0.02},
           "Gap between sleepers and ballast of the unloaded track (hanging sleepers). On a bed: "
           "height of the straight rail above the place of the sleeper when the rail is laid; its "
           "pads then lift the sleeper, as far as the rail does not bend.");
  s.choice("side", side, {"both", "left", "right"},
           "Rail, or end of the sleepers, to which the zone applies (space).");
  s.rule("to", to > from, fmt::format("must be above `from` ({:g} m)", from));
}

// Parameters of a track with two rails only.
void TrackParameters::declare_space(input::Section& s) {
  s.choice("dimension", dimension, {"plane", "space"},
           "Dimension of the track; plane: one rail with its part of vehicles and sleepers; space: "
           "two rails; sleepers and vehicles can then also roll.");
  s.number("gauge", gauge, {.unit = "m", .above = 0, .usually_from = 0.6, .usually_to = 2},
           "Distance between rail centrelines: track gauge plus head width (space, or bending "
           "sleepers).");
  s.number("sleeper_length", sleeper_length,
           {.unit = "m", .above = 0, .usually_from = 0.5, .usually_to = 5},
           "Length of the sleepers, with uniform ballast below (space, or bending sleepers).");
  s.number("sleeper_inertia", sleeper_inertia, {.unit = "kg m2", .at_least = 0},
           "Roll inertia of a whole rigid sleeper (space); 0: that of a uniform bar.");
  s.rule("rails", dimension == Dimension::plane || rails == 2,
         "must be 2 with dimension = \"space\"", {.reads = {"dimension", "rails"}});
  for (std::size_t i = 0; i < zones.size(); ++i) {
    const std::string side = fmt::format("zone[{}].side", i);
    s.rule(side, zones[i].side == ZoneSide::both || dimension == Dimension::space,
           "needs dimension = \"space\"", {.reads = {"dimension", "zone"}});
    s.rule(
        side,
        zones[i].side == ZoneSide::both ||
            (zones[i].sleeper == 1 && zones[i].footprint == 1 && zones[i].spacing == 0),
        "must be \"both\" with `sleeper`, `footprint` or `spacing`, which are of whole sleepers: "
        "give them in a zone of their own",
        {.reads = {"zone"}});
  }
}

// With these values the first bending frequency of a free sleeper of 2.6 m and 300 kg is 121 Hz;
// that of concrete monoblock sleepers is 100 to 150 Hz.
void SleeperBeamParameters::declare(input::Section& s) {
  s.choice(
      "model", model, {"rigid", "beam"},
      "Model of the sleepers; rigid: rigid bodies; beam: beams across the track; a plane track "
      "models one half of each, with symmetry at the track centre.");
  s.choice("theory", theory, {"timoshenko", "euler"},
           "Beam theory; euler: without shear deformation and rotary inertia (beam).");
  s.number("young", young, {.unit = "Pa", .above = 0, .usually_from = 1e9, .usually_to = 1e12},
           "Young's modulus of the sleepers (beam).");
  s.number("poisson", poisson, {.at_least = 0, .at_most = 0.5},
           "Poisson's ratio of the sleepers, for the shear modulus (beam, timoshenko).");
  s.number("width", width, {.unit = "m", .above = 0, .usually_from = 0.05, .usually_to = 0.6},
           "Width of the constant rectangular cross-section of the sleepers (beam).");
  s.number("height", height, {.unit = "m", .above = 0, .usually_from = 0.05, .usually_to = 0.6},
           "Height of the cross-section of the sleepers (beam).");
  s.integer("elements", elements, {.at_least = 2, .at_most = 100},
            "Number of elements of a sleeper between the rails, an even number (beam). Elements "
            "outside the rails are at most as long as these.");
  s.number("unsupported", unsupported, {.unit = "m", .at_least = 0, .usually_to = 2},
           "Unsupported length in the middle of each sleeper; the total stiffness of the ballast "
           "below the sleeper is unchanged (space, or beam).");
  s.rule("elements", elements % 2 == 0, "must be even, so that there is a node in the middle");
}

// Mass and support of a bending sleeper are distributed along it.
void TrackParameters::declare_sleepers(input::Section& s) {
  const bool bends = sleeper.model == SleeperModel::beam;
  const input::About about{.reads = {"sleeper", "support", "dimension", "rails", "gauge",
                                     "sleeper_length", "sleeper_inertia"}};
  s.rule("sleeper.model", !bends || support == Support::sleepers,
         "must be \"rigid\": the track has no sleepers (support)", about);
  s.rule("sleeper_length", !bends || sleeper_length > gauge,
         fmt::format("must be longer than the distance of the rail centrelines, track.gauge = {:g} "
                     "m: the seats are on the sleepers",
                     gauge),
         about);
  s.rule("rails", !bends || rails == 2,
         "must be 2 with bending sleepers: a plane track has half of each sleeper", about);
  s.rule("sleeper_inertia", !bends || sleeper_inertia == 0,
         "must be 0 with bending sleepers, whose roll inertia follows from their mass", about);
  s.rule("sleeper.unsupported", sleeper.unsupported < sleeper_length,
         fmt::format("must be shorter than the sleeper, which is {:g} m long", sleeper_length),
         about);
  s.rule("sleeper.unsupported", sleeper.unsupported == 0 || bends || dimension == Dimension::space,
         "has no effect on a plane track with rigid sleepers", about);
}

// A sleeper is at each border of a zone with its own spacing.
void TrackParameters::declare_spacings(input::Section& s) {
  const input::About about{.reads = {"length", "spacing", "zone"}};
  const auto such = [](double long_, double apart) {
    const double fewer = std::max(1.0, std::floor(long_ / apart));
    return fmt::format("such as {:g} or {:g} m", fewer * apart, (fewer + 1) * apart);
  };
  std::vector<std::size_t> own;
  for (std::size_t i = 0; i < zones.size(); ++i)
    if (zones[i].spacing > 0) own.push_back(i);
  std::sort(own.begin(), own.end(), [this](std::size_t one, std::size_t other) {
    return zones[one].from < zones[other].from;
  });
  if (own.empty())
    return s.rule("length", is_multiple(length, spacing),
                  fmt::format("must be a multiple of track.spacing ({:g} m), {}", spacing,
                              such(length, spacing)),
                  about);
  double end = 0;  // m, of the zone before
  const auto between = [&](const std::string& key, double to) {
    s.rule(key, to <= end + border || is_multiple(to - end, spacing),
           fmt::format("leaves {:g} m from x = {:g} m with the spacing of the track; this length "
                       "must be a multiple of track.spacing ({:g} m), {}",
                       to - end, end, spacing, such(to - end, spacing)),
           about);
  };
  for (const std::size_t i : own) {
    const TrackZone& zone = zones[i];
    const std::string key = fmt::format("zone[{}].", i);
    s.rule(key + "from", zone.from >= end - border,
           fmt::format("must be at least {:g} m, where {}: zones with `spacing` must not overlap",
                       end, end == 0 ? "the track begins" : "another zone with `spacing` ends"),
           about);
    s.rule(key + "to", zone.to <= length + border,
           fmt::format("must be at most {:g} m, the length of the track, with `spacing`", length),
           about);
    s.rule(key + "to", is_multiple(zone.to - zone.from, zone.spacing),
           fmt::format("makes the zone {:g} m long; its length must be a multiple of its spacing "
                       "({:g} m), {}",
                       zone.to - zone.from, zone.spacing, such(zone.to - zone.from, zone.spacing)),
           about);
    if (zone.from >= end - border) between(key + "from", zone.from);
    end = zone.to;
  }
  if (end <= length + border) between("length", length);
}

// All values are for one rail, except those of the sleeper, as usual in drawings.
void TrackParameters::declare(input::Section& s) {
  s.choice(
      "support", support, {"sleepers", "continuous", "none"},
      "Support of the rail; sleepers: pads, sleepers and ballast; continuous: a Winkler bed "
      "with dampers; none: the rail is supported only at its ends and represents a bridge of the "
      "span track.length.");
  s.choice("ends", ends, {"free", "pinned"},
           "Ends of the rail; pinned ends have a fixed height, equal to that of the rigid rails "
           "beyond.");
  s.integer("rails", rails, {.at_least = 1, .at_most = 2},
            "Number of rails of the track. With dimension = \"plane\" one rail is modelled; it "
            "carries 1/rails of vehicles and sleepers (1: all of them).");
  s.number("length", length, {.unit = "m", .above = 0, .usually_to = 2000},
           "Length of the track, from x = 0; beyond its ends wheels roll on rigid rails.");
  s.number("spacing", spacing, {.unit = "m", .above = 0, .usually_from = 0.1, .usually_to = 30},
           "Sleeper spacing; the length of the track, or of each part between zones with a "
           "spacing of their own, must be a multiple of it.");
  s.integer("elements", elements, {.at_least = 1, .at_most = 100},
            "Number of rail elements per sleeper spacing.");
  s.number("sleeper_mass", sleeper_mass,
           {.unit = "kg", .above = 0, .usually_from = 10, .usually_to = 2000},
           "Mass of a whole sleeper (with sleepers).");
  s.number("bed_stiffness", bed_stiffness,
           {.unit = "N/m2", .above = 0, .usually_from = 1e5, .usually_to = 1e10},
           "Stiffness of the bed below one rail, per length (continuous).");
  s.number("bed_damping", bed_damping, {.unit = "N s/m2", .at_least = 0, .usually_to = 1e7},
           "Damping of the bed below one rail, per length (continuous).");
  s.number("run_in", run_in, {.unit = "m", .at_least = 0, .usually_to = 50},
           "Length of run-in and run-out, in which rail, pads and bed become stiffer towards the "
           "rigid rails beyond; a rail without support (a bridge) has none.");
  s.number("run_in_factor", run_in_factor, {.at_least = 1, .at_most = 1e6},
           "Factor by which stiffness and damping at the ends of the track exceed those between "
           "run-in and run-out.");
  s.tables("zone", zones,
           "Parts of the track with other properties; factors of overlapping zones multiply.");
  s.table("sleeper", sleeper, "Sleepers as beams across the track.");
  declare_space(s);
  declare_sleepers(s);
  declare_spacings(s);
  s.rule("ends", support != Support::none || ends == RailEnds::pinned,
         "must be \"pinned\": the rail has no other support");
  for (std::size_t i = 0; i < zones.size(); ++i)
    s.rule(fmt::format("zone[{}].gap", i), zones[i].gap == 0 || support == Support::sleepers,
           "must be 0: the track has no sleepers (support)", {.reads = {"support", "zone"}});
  s.rule("run_in", support == Support::none || 2 * run_in <= length,
         fmt::format("must be at most {:g} m, half of track.length", length / 2));
}

// Wheel and rail oscillate against each other on the contact stiffness at several hundred Hz, and
// together on the track at 50 to 100 Hz: 0.2 ms resolves the latter well and the former roughly.
void PassageParameters::declare(input::Section& s) {
  s.number("step", step, {.unit = "s", .above = 0, .usually_from = 1e-6, .usually_to = 1e-2},
           "Time step of track and train (on a ground or a bed its upper limit).");
  auto free = s.free_to_change();
  s.number("duration", duration, {.unit = "s", .at_least = 0, .usually_to = 1000},
           "Simulated time; 0: until the last axle has left the track.");
  free.end();
  s.choice("loaded_by", loaded_by, {"train", "seats"},
           "Load of the track; train: wheels on the rail; seats: [load] on each rail seat, without "
           "pads and rail (track alone or on a ground).");
  const auto free_tolerance = s.free_to_change();
  s.number("tolerance", tolerance,
           {.unit = "m", .at_least = 1e-20, .usually_from = 1e-16, .usually_to = 1e-8},
           "Convergence tolerance of the approach of wheel and rail in each step; at 1e9 N/m, "
           "1e-12 m corresponds to 1 mN.");
}

}  // namespace trackbed::track
