// The parameters of a stage.
#include <fmt/format.h>

#include "trackbed/model/parameters.hpp"

namespace trackbed::model {

namespace {

// More than can be computed; the windows of so many trains still fit an integer.
constexpr double most_cycles = 1e6;

}  // namespace

// Parameters of every kind, and how stones are poured.
void Stage::declare_course(input::Section& s) {
  s.text("name", name, "Name of the stage, in checkpoints, histories and overrides.", {}, true);
  s.choice("kind", kind,
           {"fill", "settle", "compact", "release", "sleepers", "cribs", "load", "passage", "run",
            "shear", "triaxial", "lift_walls", "tamp", "jump"},
           "Kind of stage; fill: new stones fall; settle: stones come to rest; compact: the platen "
           "loads the bed until its pressure is steady; release: the platen is lifted slowly, so "
           "that the bed does not rebound; sleepers: sleepers are placed and settle; cribs: new "
           "stones fall into the cribs, and stones above the profile are removed at the end; load: "
           "the same force "
           "acts on all seats; passage: axles pass; run: time passes without new loads; shear: the "
           "lower half of divided walls moves along x under the platen; triaxial: the platen moves "
           "down between walls with a controlled pressure; lift_walls: walls are lifted, and "
           "removed at the end; tamp: sleepers are lifted and tines squeeze the ballast below "
           "them; jump: a few cycles with less friction settle the sleepers as many cycles would "
           "(see [jump]).");
  s.text(
      "layer", layer,
      "Name of the [[bed.layer]] that is poured (fill), on top of any existing stones; empty: the "
      "layer that [bed] itself describes, usually the uppermost one.");
  // A stage that is read (not only described) has its name and its kind at this point.
  const bool positive = !name.empty() && kind != StageKind::passage && kind != StageKind::tamp;
  s.number("duration", duration,
           {.unit = "s",
            .above = positive ? 0 : -input::unbounded,
            .at_least = positive ? -input::unbounded : 0,
            .usually_to = 100},
           "Longest simulated time of the stage. passage: time of all trains together; with 0 the "
           "stage ends when the last axle has left; with train = true and several trains (cycles "
           "above 1) it must be 0. tamp: must be 0 (the times are those of [tamping]). All other "
           "kinds: above 0.");
  s.number("growth", growth, {.unit = "s", .at_least = 0, .usually_to = 10},
           "Time in which stones grow in place from a small initial size to their full size "
           "(fill); 0: stones of full size are dropped.");
  s.number("growth_height", growth_height, {.unit = "-", .at_least = 0.5, .at_most = 10},
           "Ratio of the initial filling height of growing stones to the height of the bed (fill). "
           "Values above 1 reduce the kinetic energy of the stones and make the bed slightly "
           "looser.");
  s.number("local_damping", local_damping, {.at_least = -1, .at_most = 0.99},
           "Local damping of stones during the stage; below 0: that of the materials.");
  s.number("friction", friction, {.unit = "-", .at_least = -1, .at_most = 2},
           "Friction coefficient of all contacts during the stage, for example low to pack a bed "
           "densely; -1: that of the contact laws.");
  s.rule("friction", friction >= 0 || friction == -1,
         "must be at least 0, or -1 for the friction of the contact laws");
  s.number(
      "stiffness", stiffness, {.unit = "-", .at_least = 1e-4, .at_most = 1},
      "Stiffness of all contacts during the stage over that of the contact laws (fill, settle). "
      "Sub-steps become longer by its inverse root: a bed is poured with 0.01 in a tenth of "
      "the sub-steps. Bonds keep their stiffness.");
  s.number(
      "until_ratio", until_ratio, {.at_least = 0},
      "Ratio `unbalanced` (mean net force divided by mean contact force) below which the "
      "stage ends early, if there are also at least as many contacts as stones; 0: never. Load, "
      "passage, shear and triaxial do not use this parameter.");
}

// Parameters of bodies that move, and of the profile to which stones are cut.
void Stage::declare_bodies(input::Section& s) {
  s.flag("ground_moves", ground_moves, "Whether the ground moves; otherwise its surface is fixed.");
  s.number("lift", lift, {.unit = "m/s", .above = 0},
           "Speed at which the platen (release) or the walls (lift_walls) are lifted.");
  s.number("pressure", pressure, {.unit = "Pa", .at_least = 0, .usually_to = 1e7},
           "Target pressure of the platen (compact, shear); 0: platen.pressure.");
  s.number(
      "confinement", confinement, {.unit = "Pa", .at_least = 0, .usually_to = 1e7},
      "Target pressure on the stones from the side walls of a box (compact, triaxial); 0: walls "
      "are fixed. Opposite walls have the same displacement, controlled by a servo like that "
      "of the platen.");
  s.number("displacement", displacement, {.unit = "m"},
           "Displacement during the stage; shear: of the floor and the lower half of the walls "
           "along x; triaxial: of the platen downwards.");
  s.number("height", height, {.unit = "m", .at_least = 0, .usually_to = 5},
           "Height of the lower face of sleepers (sleepers); 0: on top of the stones.");
  s.number("profile", profile, {.unit = "m", .at_least = 0, .usually_to = 5},
           "Height of the crest (see bed.crest). When the stage begins, stones whose centre is "
           "above the crest or above the slopes beside it are removed; 0: no stones are removed. A "
           "stage of kind cribs fills cribs up to this height and removes stones above it at its "
           "end. A stage of kind fill cannot have a profile.");
}

void Stage::declare_loads(input::Section& s) {
  s.number("seat_force", seat_force, {.unit = "N", .usually_from = -1e6, .usually_to = 1e6},
           "Constant force on each sleeper, positive downwards; a sleeper with two seats has half "
           "of it on "
           "each.");
  s.number("load", load, {.unit = "N", .usually_from = -1e6, .usually_to = 1e6},
           "Peak force on each sleeper, positive downwards, in addition to seat_force (load; jump: "
           "of the "
           "cycles that it represents).");
  s.number("ramp", ramp, {.unit = "s", .at_least = 0},
           "Ramp time, at most half the duration; load: time of loading and of unloading; compact: "
           "time in which pressure and confinement change from those of the preceding stage; "
           "shear, triaxial: the same, and also the time in which full speed is reached; passage: "
           "time in which a kept rail takes up its forces, and in which wheels that start on solid "
           "rails take up their load, in each train.");
  s.integer("cycles", cycles, {.at_least = 0, .at_most = most_cycles},
            "Number of cycles; load: number of haversines in the duration (0: one ramp up, hold "
            "and ramp down); passage: number of successive trains (0: one); tamp: number of "
            "insertions of the tines (0: one); jump: number of cycles or trains that it "
            "represents.");
  s.flag("train", train,
         "Whether the sleepers are loaded by the vehicles of [train] (through rail and pads) or by "
         "the axle loads of [load] (passage).");
  s.choice(
      "rail", rail, {"laid", "kept"},
      "Rail of a train on a bed at the begin of the stage (train = true); laid: without load on "
      "the sleepers as they are; kept: that of the preceding train, whose pads take up their "
      "forces within `ramp`: it lifts the sleepers that have settled more than their "
      "neighbours since.");
  s.number("settlement", settlement, {.unit = "m", .at_least = 0, .usually_to = 2e-3},
           "The stage ends early after a cycle in which no sleeper settles by more than this value "
           "(load and passage with cycles); 0: the stage does not end early.");
}

// One struct for all kinds: a parameter that a kind does not use keeps its default. The rules at
// the end state what each kind needs.
void Stage::declare(input::Section& s) {
  declare_course(s), declare_bodies(s), declare_loads(s);
  constexpr double least = 100;  // N, smallest load that is relevant for a sleeper
  for (const auto& [key, force] : {std::pair{"seat_force", seat_force}, {"load", load}})
    s.rule(key, force >= 0, "lifts the sleepers: forces are positive downwards",
           {.severity = input::Severity::warning, .reads = {key}});
  for (const auto& [key, force] : {std::pair{"seat_force", seat_force}, {"load", load}})
    s.rule(key, force == 0 || std::abs(force) >= least,
           fmt::format("is negligible for a rail seat (below {:g} N); is it in N?", least),
           {.severity = input::Severity::warning, .reads = {key}});
  constexpr double shortest = 0.02;  // s, of a cycle: an axle loads a sleeper for longer
  s.rule("cycles", kind != StageKind::load || cycles == 0 || duration >= shortest * cycles,
         fmt::format("gives cycles of {:.3g} s, in which inertia carries a part of the load: give "
                     "them at least {:g} s by a longer duration or fewer cycles",
                     duration / static_cast<double>(std::max<std::int64_t>(1, cycles)), shortest),
         {.severity = input::Severity::warning, .reads = {"kind", "duration", "cycles"}});
  const bool tamps = kind == StageKind::tamp;
  s.rule("duration", kind == StageKind::passage || tamps || duration > 0,
         "must be above 0 s for this kind of stage");
  s.rule("duration", !tamps || duration == 0,
         "must be 0 s for stages of kind tamp: their times are those of [tamping]",
         {.reads = {"kind", "duration"}});
  s.rule("profile", kind != StageKind::cribs || profile > 0, "must be above 0 m to fill cribs");
  s.rule("profile", kind != StageKind::fill || profile == 0,
         "has no effect while stones still fall; give it to a later stage");
  s.rule("growth", growth <= duration,
         fmt::format("is longer than the stage ({:g} s): stones would not reach their full size",
                     duration),
         {.reads = {"duration", "growth"}});
  s.rule("layer", kind == StageKind::fill || layer.empty(), "is for stages of kind fill only",
         {.reads = {"kind", "layer"}});
  const bool loaded = kind == StageKind::load || kind == StageKind::passage;
  const bool jumps = kind == StageKind::jump;
  s.rule("cycles", cycles == 0 || loaded || tamps || jumps,
         "is for stages of kind load, passage, tamp and jump only");
  s.rule("cycles", cycles > 0 || !jumps, "must be at least 1: the cycles that a jump represents");
  s.rule("settlement", settlement == 0 || cycles > 0, "needs at least one cycle (cycles)");
}

}  // namespace trackbed::model
