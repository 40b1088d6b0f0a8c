// All parameters of a deck that no single room owns, and which steps are grossly unstable. Rooms
// declare their own sections; the order here is the order of docs/input.md.
//
// A parameter stands here once: variable, unit, bounds and sentence; reader, reference, schema and
// effective input all follow from it. Bounds are what the program can compute; `usually` is what a
// railway has, and beyond it a unit has most likely been mistaken.
#include "app/parameters.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/ground_alone.hpp"
#include "app/limits.hpp"
#include "app/placed_rules.hpp"
#include "app/rules.hpp"

namespace trackbed::app {

namespace {

// More than anybody can compute; the windows of so many trains still fit an integer.
constexpr double most_cycles = 1e6;

constexpr const char* footing_meaning =
    "Where sleepers of model = \"track_on_ground\" rest on its ground.";
constexpr const char* pressure_meaning =
    "Even pressures on rectangles of the top of model = \"ground\".";
constexpr double room_beside_floor = 0.25;  // m
// Of the bed's larger side: how far walls that hold a pressure may give way. At 15 % of axial
// strain a bed of twice that height widens by a fifth or so.
constexpr double room_for_walls = 0.5;

}  // namespace

// What every kind has, and how stones are poured.
void Stage::declare_course(input::Section& s) {
  s.text("name", name, "Name of the stage, in checkpoints, histories and overrides.", {}, true);
  s.choice(
      "kind", kind,
      {"fill", "settle", "compact", "release", "sleepers", "cribs", "load", "passage", "run",
       "shear", "triaxial", "lift_walls", "tamp"},
      "fill: new stones fall; settle: stones come to rest; compact: the platen presses until "
      "steady; release: it is lifted slowly, so that the bed does not spring apart; sleepers: "
      "they are placed and settle; cribs: new stones fall between them and are cut at the "
      "profile; load: the same force on all seats; "
      "passage: axles pass; run: nothing but time; shear: the lower half of divided walls moves "
      "along x under the platen; triaxial: the platen goes down between walls that hold a "
      "pressure; lift_walls: walls go up, and away at the end; tamp: sleepers are lifted and "
      "tines squeeze the ballast below them.");
  s.text(
      "layer", layer,
      "Fill: the [[bed.layer]] that is poured, on top of what is there; none: the uppermost one, "
      "which [bed] itself describes.");
  // A stage that is not described but read has its name and its kind by now.
  const bool positive = !name.empty() && kind != StageKind::passage && kind != StageKind::tamp;
  s.number("duration", duration,
           {.unit = "s",
            .above = positive ? 0 : -input::unbounded,
            .at_least = positive ? -input::unbounded : 0,
            .usually_to = 100},
           "Simulated time, at most; passage: of all its trains together, 0 means until the last "
           "axle has left. Not of tamp, which takes what [tamping] says.");
  s.number("growth", growth, {.unit = "s", .at_least = 0, .usually_to = 10},
           "Fill: time in which stones grow to their size in place, begun so small that they fill "
           "the height of the bed loosely, instead of falling from far above it; 0: they fall.");
  s.number("growth_room", growth_room, {.unit = "-", .at_least = 0.5, .at_most = 10},
           "Fill with growth: the height that stones begin in over that of the bed. More than 1, "
           "and they throw each other about less; the bed is then a little looser.");
  s.number("local_damping", local_damping, {.at_least = -1, .at_most = 0.99},
           "Local damping of stones during the stage; below 0: the materials' own.");
  s.number("friction", friction, {.unit = "-", .at_least = -1, .at_most = 2},
           "Friction coefficient of all contacts during the stage, as when a bed is made dense by "
           "packing it with little friction; below 0: the contacts' own.");
  s.number("until_ratio", until_ratio, {.at_least = 0},
           "The stage ends early once the mean unbalanced force over the mean contact force is "
           "below this; 0: never. Not used by load and passage.");
}

// What moves beside the stones, and where they are cut.
void Stage::declare_bodies(input::Section& s) {
  s.flag("ground_moves", ground_moves, "Whether the ground moves; else its surface is held still.");
  s.number("lift", lift, {.unit = "m/s", .above = 0},
           "Release: speed of the platen upwards. Lift_walls: of the walls.");
  s.number("pressure", pressure, {.unit = "Pa", .at_least = 0, .usually_to = 1e7},
           "Compact and shear: what the platen holds; 0: platen.pressure.");
  s.number("confinement", confinement, {.unit = "Pa", .at_least = 0, .usually_to = 1e7},
           "Compact and triaxial: what the side walls of a box hold on the stones, opposite ones "
           "going the same way under a servo as the platen's; 0: they stay where they are.");
  s.number("displacement", displacement, {.unit = "m"},
           "Shear: way of floor and lower half along x in the duration. Triaxial: way of the "
           "platen down.");
  s.number("height", height, {.unit = "m", .at_least = 0, .usually_to = 5},
           "Sleepers: their lower face; 0: on top of the stones.");
  s.number(
      "profile", profile, {.unit = "m", .at_least = 0, .usually_to = 5},
      "Height of the crest (see bed.crest): stones with their centre above it, or above the slopes "
      "beside it, are taken away when the stage begins; 0: none. Cribs: the height they are filled "
      "to, and what lies higher goes at the end. Not for fill.");
}

void Stage::declare_loads(input::Section& s) {
  s.number("seat_force", seat_force, {.unit = "N", .usually_from = -1e6, .usually_to = 1e6},
           "Constant force on each rail seat, downwards.");
  s.number("load", load, {.unit = "N", .usually_from = -1e6, .usually_to = 1e6},
           "Load: peak on each rail seat, above seat_force.");
  s.number(
      "ramp", ramp, {.unit = "s", .at_least = 0},
      "Load: time from zero to the peak and, at the end, back. Shear and triaxial: time to full "
      "speed. Compact, shear and triaxial: time in which pressure and confinement change from "
      "those of the stage before. Half the duration at most.");
  s.integer("cycles", cycles, {.at_least = 0, .at_most = most_cycles},
            "Load: haversines in the duration; 0: ramp, hold, ramp. Passage: trains, one after the "
            "other; 0: one. Tamp: insertions of the tines; 0: one.");
  s.flag("train", train,
         "Passage: the vehicles of [train] run over rail and pads on the sleepers, instead of the "
         "axles of [load].");
  s.number("settlement", settlement, {.unit = "m", .at_least = 0},
           "Load and passage with cycles: the stage ends early once no sleeper has gone down by "
           "more than this in the last cycle; 0: never.");
}

// One struct for all kinds: a parameter that a kind does not use keeps its default. Rules at the
// end say what a kind cannot do without.
void Stage::declare(input::Section& s) {
  declare_course(s), declare_bodies(s), declare_loads(s);
  constexpr double least = 100;  // N, of a load that means something to a sleeper
  for (const auto& [key, force] : {std::pair{"seat_force", seat_force}, {"load", load}})
    s.rule(key, force == 0 || std::abs(force) >= least,
           "is next to nothing for a rail seat: is it in N?",
           {.weight = input::Weight::warning, .reads = {key}});
  const bool tamps = kind == StageKind::tamp;
  s.rule("duration", kind == StageKind::passage || tamps || duration > 0,
         "must be above 0 s for this kind of stage");
  s.rule("duration", !tamps || duration == 0,
         "is not for stages of kind tamp: times are those of [tamping]",
         {.reads = {"kind", "duration"}});
  s.rule("profile", kind != StageKind::cribs || profile > 0, "must be above 0 m to fill cribs");
  s.rule("profile", kind != StageKind::fill || profile == 0,
         "cuts nothing while stones still fall; give it to a later stage");
  s.rule("growth", growth <= duration,
         fmt::format("is longer than the stage ({:g} s): stones would stay small", duration),
         {.reads = {"duration", "growth"}});
  s.rule("layer", kind == StageKind::fill || layer.empty(), "is for stages of kind fill only",
         {.reads = {"kind", "layer"}});
  const bool loaded = kind == StageKind::load || kind == StageKind::passage;
  s.rule("cycles", cycles == 0 || loaded || tamps,
         "is for stages of kind load, passage and tamp only");
  s.rule("settlement", settlement == 0 || cycles > 0, "needs cycles, at least 1");
}

// Zeros mean "chosen": most decks should say nothing here.
void TimeParameters::declare(input::Section& s) {
  s.number("window", window, {.unit = "s", .at_least = 0},
           "Length of a time window of the coupling; 0: as many sub-steps as `substeps` says, or "
           "what the coupling allows if that is less.");
  s.number("step", step, {.unit = "s", .at_least = 0},
           "Sub-step of the stones; 0: chosen from stability.");
  s.integer("substeps", substeps, {.at_least = 1, .at_most = 10000},
            "Sub-steps in a window if `window` is 0, as far as the coupling allows.");
  // Twice: the lightest stone is known only once there are stones, and then the limit is exact.
  s.rule(
      "step", step <= 2 * rough_step,
      fmt::format("is unstable: the stiffest contact and the lightest stone allow about {:.3g} s",
                  rough_step));
  s.rule("step", step == 0 || step >= 1e-3 * rough_step || rough_step == input::unbounded,
         fmt::format("is less than a thousandth of what stability asks for, about {:.3g} s",
                     rough_step),
         {.weight = input::Weight::warning, .reads = {"step"}});
  s.rule("step", window == 0 || step <= window,
         fmt::format("is longer than the window of {:g} s, which is taken in one sub-step", window),
         {.weight = input::Weight::warning, .reads = {"window", "step"}});
  s.rule("substeps", window == 0 || substeps == 1,
         "has no effect: the window is given, and the stones' sub-steps fill it",
         {.weight = input::Weight::warning, .reads = {"window", "substeps"}});
  s.rule("window", window <= rough_window,
         fmt::format("is unstable: contact stiffness and the mass of what the stones touch allow "
                     "{:.3g} s",
                     rough_window));
}

void Output::declare(input::Section& s) {
  s.number(
      "history_interval", history_interval, {.unit = "s", .at_least = 0},
      "Simulated time between rows of the histories, rounded to windows; 0: a row after each.");
  s.flag("fields", fields, "Write fields for ParaView at the end of each stage.");
  s.number(
      "fields_interval", fields_interval, {.unit = "s", .at_least = 0},
      "Simulated time between fields within a stage; 0: only at its end. Needs fields = true.");
  s.flag("ground_extremes", ground_extremes,
         "Add the extremes of each element's stress over the history rows and the fields of the "
         "stage to the ground's fields, in stages in which it moves. Asked for amid a stage, they "
         "count from there on. Needs fields = true.");
  s.rule("ground_extremes", !ground_extremes || fields, "has no effect without fields = true",
         {.weight = input::Weight::warning, .reads = {"fields", "ground_extremes"}});
  s.number(
      "surface_cell", surface_cell, {.unit = "m", .at_least = 1e-3, .usually_to = 1},
      "Width of the cells in which the height of the bed is written at the end of each stage.");
  s.number("checkpoint_interval", checkpoint_interval, {.unit = "s", .at_least = 0},
           "Simulated time between checkpoints within a stage; 0: only at its end.");
  s.number("wall_time", wall_time, {.unit = "s", .at_least = 0},
           "Wall time after which a checkpoint is written and the run stops; 0: no limit.");
  s.integer("stop_after", stop_after, {.at_least = 0},
            "Time windows, counted from the first of the run also after a resume, after which a "
            "checkpoint is written and the run stops; 0: no limit.");
}

// Space, ground and track; nothing that stones have.
void Model::declare_on_ground(input::Section& s) {
  declare_space(s);
  s.table("ground", ground, "The continuum below the bed.");
  track.declare(s);
  s.table("footing", footing, footing_meaning);
  declare_footing(*this, s);
}

// Space, ground and its loads; stages, steps and output as of a bed.
void Model::declare_ground_alone(input::Section& s) {
  declare_space(s);
  s.table("ground", ground, "The continuum below the bed.");
  s.tables("pressure", pressures, pressure_meaning);
  s.table("output", output, "What is written, and when the run stops early.");
  s.tables("stage", stages, "What is done, one after the other.");
  time.rough_step = time.rough_window = input::unbounded;
  s.table("time", time, "Steps in time.");
  declare_stages_alone(*this, s);
  declare_pressures(*this, s);
}

void Model::declare_space(input::Section& s) {
  s.choice("dimension", dimension, {"plane", "space"}, "In which space the model lives.");
  s.number(
      "thickness", thickness, {.unit = "m", .above = 0, .usually_from = 0.01, .usually_to = 10},
      "Extent of a plane model across the track: that of half a sleeper if seat loads are those of "
      "one rail.");
  physics.thickness = dimension == Dimension::plane ? thickness : 0;
}

void Model::declare(input::Section& s) {
  s.text("title", title, "What the deck is about.");
  s.choice(
      "model", kind, {"bed", "track", "track_on_ground", "ground", "stones"},
      "bed: stones, ground and sleepers under seat loads; track: a train on rail and springs "
      "alone, made of title and the sections that say so; track_on_ground: the same with "
      "[ground] below the springs of some sleepers; ground: [ground] alone under [[pressure]], "
      "in stages of kind run; stones: each [[stone]], [[plate]] and [[box]] where the deck places "
      "it, "
      "in stages of kind run and settle.");
  track.on_bed = kind == ModelKind::bed;
  track.on_ground = kind == ModelKind::track_on_ground;
  if (kind == ModelKind::ground) return declare_ground_alone(s);
  if (kind == ModelKind::stones) return declare_placed(s);
  if (kind == ModelKind::track) return track.declare(s);
  if (kind == ModelKind::track_on_ground) return declare_on_ground(s);
  declare_bed(s);
  declare_time(s);
  declare_intervals(*this, s);
  declare_ground_mesh(*this, s);
  track.declare(s);
  sleepers.gauge = has_train() ? track.line.track.wheel_gauge() : load.gauge;
  declare_train(*this, s);
  declare_solids(*this, s);
  s.table("footing", footing, footing_meaning);
  declare_footing(*this, s);
  s.tables("pressure", pressures, pressure_meaning);
  declare_pressures(*this, s);
  placed.declare(s);
  declare_no_placed(placed, s);
  s.table("handover", handover, "The hand-over loop; read by jobs/handover.py, not by `run`.");
  declare_handover(*this, s);
}

void Model::declare_bed(input::Section& s) {
  declare_space(s);
  s.texts("periodic", periodic, "Sides that meet each other: any of \"x\", \"y\".");
  s.file(
      "start", start,
      "Checkpoint (a file stage_*.h5, or a result folder: the one its `latest` names): the stages "
      "up to the one it was written after are not done again.",
      input::Named::origin);
  s.text("wall_material", wall_material, "Contact material of walls and platen.");
  s.text("ground_material", ground_material,
         "Contact material of the ground's surface, or of the floor where there is no ground.");
  s.number("settle_average", settle_average, {.unit = "s", .at_least = 0},
           "Time constant of the averaged load of the bed under which the ground is in equilibrium "
           "before it is let go.");
  physics.declare(s);
  s.table("dem", dem, "How stones are moved.");
  s.table("bed", bed, "The ballast bed.");
  s.table("ground", ground, "The continuum below the bed.");
  s.table("sleepers", sleepers, "Sleepers; they exist if a stage places them.");
  s.table("solid", solid, "Sleepers as solids (sleepers.model = \"solid\"), and rails on them.");
  s.table("load", load, "Load on the rail seats while axles pass.");
  s.table("seat", seat, "Where the rail of a stage with train = true rests on the bed.");
  s.table("platen", platen, "The plate that compacts the bed.");
  s.table("tamping", tamping, "The tines of stages of kind tamp.");
  s.table("output", output, "What is written, and when the run stops early.");
  s.tables("region", regions,
           "Parts of space in which the stones are measured at each row of the histories.");
  s.tables("stage", stages, "What is done, one after the other.");
  declare_rules(*this, s);
}

// The rough limits follow when all they depend on has been read.
void Model::declare_time(input::Section& s) {
  // Sleepers have their density from their material; the coupling limit needs their mass.
  if (const int number = material(sleepers.material); number >= 0)
    sleepers.density = physics.materials[static_cast<std::size_t>(number)].density;
  time.rough_step = rough_step_limit(*this);
  time.rough_window = coupling_limit(*this, true).window;
  s.table("time", time, "Steps in time.");
}

bool Model::periodic_in(const std::string& axis) const {
  return std::find(periodic.begin(), periodic.end(), axis) != periodic.end();
}

bool Model::has_stage(StageKind kind) const {
  return std::any_of(stages.begin(), stages.end(),
                     [&](const Stage& stage) { return stage.kind == kind; });
}

bool Model::has_one_grading() const {
  return start.empty() && bed.cell.empty() &&
         std::count_if(stages.begin(), stages.end(),
                       [](const Stage& stage) { return stage.kind == StageKind::fill; }) == 1;
}

bool Model::uses_platen() const {
  return std::any_of(stages.begin(), stages.end(),
                     [](const Stage& stage) { return presses(stage.kind); });
}

// Walls stand at sides that are not periodic. The floor is of the ground's material.
bool Model::uses_walls() const {
  const bool open = !periodic_in("x") || (dimension == Dimension::space && !periodic_in("y"));
  return open || has_stage(StageKind::compact);
}

bool Model::has_train() const {
  return std::any_of(stages.begin(), stages.end(), [](const Stage& stage) { return stage.train; });
}

bool Model::has_solid_rails() const {
  return sleepers.model == track::SleeperBody::solid && solid.rails;
}

bool Model::uses_sleepers() const {
  return has_stage(StageKind::sleepers) || has_stage(StageKind::cribs) ||
         has_stage(StageKind::load) || has_stage(StageKind::passage) || has_stage(StageKind::tamp);
}

double Model::pressure_in(const Stage& stage) const {
  return stage.pressure > 0 ? stage.pressure : platen.pressure;
}

// The lattice of `fill` reaches a few times the height of the bed; below z = 0 there is room for
// the ground to sink.
// A stone that leaves the box in z is lost and stops the run: so the box is generous. In a plane
// model y has just the thickness.
dem::Domain Model::domain() const {
  if (is_placed()) return domain_of_placed(*this);
  dem::Domain domain;
  domain.dimension = dimension;
  domain.thickness = dimension == Dimension::plane ? thickness : 1;
  const bool open = !has_stones();  // nobody needs walls then
  domain.periodic = {open || periodic_in("x"),
                     dimension == Dimension::space && (open || periodic_in("y")), false};
  const bool plane = dimension == Dimension::plane;
  domain.low = {bed.x[0], plane ? -thickness / 2 : bed.y[0], -0.2};
  double height = bed.height;
  for (const bed::NamedLayer& layer : bed.layers) height += layer.height;
  domain.high = {bed.x[1], plane ? thickness / 2 : bed.y[1], 10 * height + 1};
  // Stones that run off the floor are taken away before they reach the end of this.
  double around = bed.beside > 0 ? bed.beside + room_beside_floor : 0;
  for (const Stage& stage : stages)
    if (stage.confinement > 0)
      around = std::max(
          around, room_for_walls * std::max(bed.x[1] - bed.x[0], domain.high.y() - domain.low.y()));
  for (int axis = 0; axis < (plane ? 1 : 2); ++axis)
    if (!domain.periodic[static_cast<std::size_t>(axis)])
      domain.low[axis] -= around, domain.high[axis] += around;
  return domain;
}

// Stones that are placed one by one have no walls around them but those that are placed as well.
bed::Container Model::container() const {
  bed::Container container = bed.container_in(domain());
  if (is_placed()) container.periodic = {true, true};
  return container;
}

}  // namespace trackbed::app
