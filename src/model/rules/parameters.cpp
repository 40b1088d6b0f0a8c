// All parameters of a deck that belong to no single module, and rough limits of the steps. Modules
// declare their own sections; the order here is the order of docs/input.md.
//
// A parameter is declared once: variable, unit, bounds and sentence; reader, reference, schema and
// effective input all follow from it. Bounds are what the program can compute; `usually` is the
// range of railways, outside of which a unit is most likely wrong.
#include "trackbed/model/parameters.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "model/rules/ground_alone.hpp"
#include "model/rules/limits.hpp"
#include "model/rules/placed_rules.hpp"
#include "model/rules/rules.hpp"
#include "trackbed/observe/output_parts.hpp"

namespace trackbed::model {

namespace {

constexpr const char* footing_meaning =
    "Footprints of the sleepers on the ground (model = \"track_on_ground\").";
constexpr const char* output_meaning = "What is written, and when the run stops early.";
constexpr const char* sensor_meaning =
    "Sensors in the bed and in the ground, read at each row of the histories.";
constexpr const char* pressure_meaning =
    "Uniform pressures on rectangles of the top of the ground (model = \"ground\").";
constexpr double margin_beside_floor = 0.25;  // m
// Fraction of the bed's larger side by which walls with a controlled pressure may move. At 15 % of
// axial strain a bed of twice that height widens by about a fifth.
constexpr double margin_for_walls = 0.5;

// The values of a list are some of those known.
void declare_only(const char* key, const std::vector<std::string>& given, const auto& known,
                  input::Section& s) {
  const bool all = std::all_of(given.begin(), given.end(), [&](const std::string& part) {
    return std::find(known.begin(), known.end(), part) != known.end();
  });
  s.rule(key, all, fmt::format("may contain only {}", fmt::join(known, ", ")));
}

}  // namespace

// 0 means chosen by the program: most decks need no values here.
void TimeParameters::declare(input::Section& s) {
  s.number("window", window, {.unit = "s", .at_least = 0},
           "Length of a time window of the coupling; 0: `substeps` sub-steps, or the stable window "
           "of the coupling if that is shorter.");
  s.number("step", step, {.unit = "s", .at_least = 0},
           "Sub-step of the stones; 0: chosen from stability.");
  s.integer("substeps", substeps, {.at_least = 1, .at_most = 10000},
            "Number of sub-steps in a window if `window` is 0, as far as the coupling allows.");
  // Up to twice the estimate: the limit is exact once the lightest stone is known.
  s.rule("step", step <= 2 * rough_step,
         fmt::format("is too long: the stiffest contact, the lightest stone and the factor "
                     "dem.safety allow about {:.3g} s",
                     rough_step));
  s.rule("step", step == 0 || step >= 1e-3 * rough_step || rough_step == input::unbounded,
         fmt::format("is less than a thousandth of the stable step of about {:.3g} s; is it in s?",
                     rough_step),
         {.severity = input::Severity::warning, .reads = {"step"}});
  s.rule(
      "step", window == 0 || step <= window,
      fmt::format("is longer than the window of {:g} s: each window is then one sub-step", window),
      {.severity = input::Severity::warning, .reads = {"window", "step"}});
  s.rule("substeps", window == 0 || substeps == 1,
         "has no effect: time.window is given, and the number of sub-steps follows from it",
         {.severity = input::Severity::warning, .reads = {"window", "substeps"}});
  s.rule("window", window <= rough_window,
         fmt::format("is unstable: contact stiffness and the mass of the bodies in contact with "
                     "stones allow about {:.3g} s",
                     rough_window));
}

void RunOutput::declare(input::Section& s) {
  s.number("history_interval", history_interval, {.unit = "s", .at_least = 0},
           "Simulated time between rows of the histories, rounded to windows; 0: a row after each "
           "window.");
  const auto free = s.free_to_change();
  s.number(
      "checkpoint_interval", checkpoint_interval, {.unit = "s", .at_least = 0},
      "Simulated time between checkpoints within a stage, rounded to windows; 0: none within the "
      "stage but those of checkpoint_wall_interval and of a stop.");
  s.number("checkpoint_wall_interval", checkpoint_wall_interval, {.unit = "s", .at_least = 0},
           "Wall time after the last checkpoint at which another one is written; 0: none.");
  s.number("wall_time", wall_time, {.unit = "s", .at_least = 0},
           "Wall time after which a checkpoint is written and the run stops; 0: no limit.");
  s.integer("stop_after", stop_after, {.at_least = 0},
            "Number of time windows after which a checkpoint is written and the run stops. Windows "
            "are counted from the start of the run, also after a resume; 0: no limit.");
  s.flag("compress", compress,
         "Whether results.h5 is compressed, without loss (shuffle and deflate), when the run ends; "
         "that of the models track and track_on_ground whenever it is written.");
}

void FieldOutput::declare(input::Section& s) {
  RunOutput::declare(s);
  const auto free = s.free_to_change();
  s.flag("fields", fields,
         "Whether fields for ParaView are written at the end of each stage, or of the passage of a "
         "track.");
  s.number(
      "fields_interval", fields_interval, {.unit = "s", .at_least = 0},
      "Simulated time between fields within a stage; 0: only at its end. Needs fields = true.");
  s.rule("fields_interval", fields_interval == 0 || fields, "has no effect without fields = true",
         {.severity = input::Severity::warning, .reads = {"fields", "fields_interval"}});
  s.texts("fields_parts", fields_parts,
          "Parts of the model whose fields are written: any of stones, contacts, bonds, ground, "
          "solids, "
          "surfaces (sleepers, walls, plates, boxes, platen) and train (rails and wheels). Needs "
          "fields = true.");
  declare_only("fields_parts", fields_parts, observe::field_parts, s);
  s.rule("fields_parts", fields || fields_parts == FieldOutput{}.fields_parts,
         "has no effect without fields = true",
         {.severity = input::Severity::warning, .reads = {"fields", "fields_parts"}});
}

bool Output::has_fields(const Stage& stage) const {
  const auto& names = fields_stages;
  return fields &&
         (names.empty() || std::find(names.begin(), names.end(), stage.name) != names.end());
}

void Output::declare(input::Section& s) {
  FieldOutput::declare(s);
  s.texts("fields_stages", fields_stages,
          "Names of the stages in which fields are written; empty: all. Needs fields = true.");
  s.rule("fields_stages", fields || fields_stages.empty(), "has no effect without fields = true",
         {.severity = input::Severity::warning, .reads = {"fields", "fields_stages"}});
  s.texts("histories", histories,
          "Parts of the model whose histories are written: any of energy, sleeper, ground, region, "
          "wall, platen, train (wheels, rail, vehicles, seats), solid (solid sleepers), sensor and "
          "stone (placed stones, plates and boxes). If sleeper or ground is left out, its "
          "envelopes are not written either.");
  declare_only("histories", histories, observe::history_parts, s);
  s.flag("ground_extremes", ground_extremes,
         "Whether the ground's fields include running extremes of the element stresses, updated at "
         "each history row and field file while the ground moves. If a resume within a stage "
         "switches this on, earlier times are not included. Needs fields = true.");
  s.rule("ground_extremes", !ground_extremes || fields, "has no effect without fields = true",
         {.severity = input::Severity::warning, .reads = {"fields", "ground_extremes"}});
  s.number(
      "surface_cell", surface_cell, {.unit = "m", .at_least = 1e-3, .usually_to = 1},
      "Width of the cells in which the height of the bed is written at the end of each stage.");
}

// A track alone.
void Model::declare_passage(input::Section& s) {
  track.declare(s);
  s.table("output", static_cast<FieldOutput&>(output), output_meaning);
  const double step = track.passage.step, interval = output.history_interval;
  s.rule("output.history_interval", track.on_ground || interval == 0 || interval >= step,
         "is less than a time step (passage.step): a row is then written after every step",
         {.severity = input::Severity::warning, .reads = {"passage", "output"}});
}

// Space, ground and track, without stones.
void Model::declare_on_ground(input::Section& s) {
  declare_space(s);
  s.table("ground", ground, "The continuum below the bed.");
  declare_passage(s);
  s.table("footing", footing, footing_meaning);
  s.tables("sensor", sensors, sensor_meaning);
  declare_footing(*this, s);
  declare_sensors(*this, s);
}

// Space, ground and its loads; stages, steps and output as of a bed.
void Model::declare_ground_alone(input::Section& s) {
  declare_space(s);
  s.table("ground", ground, "The continuum below the bed.");
  s.tables("pressure", pressures, pressure_meaning);
  s.table("output", output, output_meaning);
  s.tables("sensor", sensors, sensor_meaning);
  s.tables("stage", stages, "The stages of the run, one after the other.");
  time.rough_step = time.rough_window = input::unbounded;
  s.table("time", time, "Time steps.");
  declare_stages_alone(*this, s);
  declare_pressures(*this, s);
  declare_sensors(*this, s);
}

void Model::declare_space(input::Section& s) {
  const auto fixed = s.fixed_by(input::state::any);
  s.choice("dimension", dimension, {"plane", "space"},
           "Dimension of the model; plane: x and z; space: x, y and z.");
  s.number("thickness", thickness,
           {.unit = "m", .at_least = 1e-4, .usually_from = 0.01, .usually_to = 10},
           "Thickness of a plane model across the track; half the sleeper length if seat loads are "
           "those of one rail.");
  physics.thickness = dimension == Dimension::plane ? thickness : 0;
}

void Model::declare(input::Section& s) {
  s.text("title", title, "Title of the deck.");
  // The state of a track alone or on a ground is the motion of a model that is built again from the
  // deck, and depends on nearly every parameter.
  const auto fixed = s.fixed_by(has_stages() ? input::state::none : input::state::passage);
  s.choice(
      "model", kind, {"bed", "track", "track_on_ground", "ground", "stones"},
      "Kind of model; bed: stones, ground and sleepers under seat loads; track: a train on rail, "
      "pads, sleepers and springs, without stones and ground (a track alone); track_on_ground: a "
      "track alone with [ground] below the springs of some sleepers; ground: [ground] alone under "
      "[[pressure]], in stages of kind run; stones: each [[stone]], [[plate]] and [[box]] as "
      "placed by the deck, in stages of kind run and settle.");
  track.on_bed = kind == ModelKind::bed;
  track.on_ground = kind == ModelKind::track_on_ground;
  if (kind == ModelKind::ground) return declare_ground_alone(s);
  if (kind == ModelKind::stones) return declare_placed(s);
  if (kind == ModelKind::track) return declare_passage(s);
  if (kind == ModelKind::track_on_ground) return declare_on_ground(s);
  declare_bed(s);
  declare_time(s);
  declare_rules(*this, s);  // which also read the time steps
  declare_intervals(*this, s);
  declare_ground_mesh(*this, s);
  declare_delay(*this, s);
  declare_held_again(*this, s);
  declare_begin_of_motion(*this, s);
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
  s.table("handover", handover,
          "Long-term settlement by alternating runs of a track alone and of the bed "
          "(docs/track.md); used by jobs/handover.py, ignored by `trackbed run`.");
  declare_handover(*this, s);
  s.table("jump", jump, "Jumps over cycles of load, stages of kind jump (docs/settlement.md).");
  declare_jump(*this, s);
  declare_jump_period(*this, s);
}

void Model::declare_bed(input::Section& s) {
  declare_space(s);
  auto fixed = s.fixed_by(input::state::any);
  s.texts("periodic", periodic, "Axes along which the bed is periodic: any of \"x\", \"y\".");
  fixed.end();
  s.file("start", start,
         "Checkpoint from which the run starts: a file stage_*.h5, or a result folder, whose "
         "latest checkpoint is then used. The stages before it are not computed again.",
         input::FileRole::origin);
  s.text("wall_material", wall_material, "Contact material of walls and platen.");
  s.text("ground_material", ground_material,
         "Contact material of the ground's surface, or of the floor if there is no ground.");
  s.number("settle_average", settle_average, {.unit = "s", .at_least = 0},
           "Time constant of the average of the bed's load on the ground. Before the ground starts "
           "to move, it is in static equilibrium with this averaged load.");
  physics.declare(s);
  s.table("dem", dem, "Integration and contact search of stones.");
  s.table("bed", bed, "The ballast bed.");
  s.table("ground", ground, "The continuum below the bed.");
  s.table("sleepers", sleepers, "Sleepers; they exist if a stage places them.");
  s.table("solid", solid, "Sleepers as solids (sleepers.model = \"solid\"), and rails on them.");
  s.table("load", load,
          "Load on the rail seats while axles pass (stages of kind passage; for stages of kind "
          "load see stage.load).");
  {
    const auto fixed_by_train = s.fixed_by(input::state::train);
    s.table("seat", seat,
            "How the bed lies in the track of a passage with train = true: where it begins, and "
            "how many rails its sleepers carry.");
  }
  s.table("platen", platen, "The plate that compacts the bed.");
  {
    const auto fixed_by_tines = s.fixed_by(input::state::tines);
    s.table("tamping", tamping, "The tines of stages of kind tamp.");
  }
  s.table("breakage", breakage, breakage_meaning);
  s.tables("bond", bonds, bond_meaning);
  s.table("output", output, output_meaning);
  s.tables("region", regions, "Regions in which stones are measured at each row of the histories.");
  s.tables("sensor", sensors, sensor_meaning);
  s.tables("stage", stages, "The stages of the run, one after the other.");
}

// The rough limits are computed when all that they depend on has been read.
void Model::declare_time(input::Section& s) {
  // Sleepers have their density from their material; the coupling limit needs their mass.
  if (const int number = material(sleepers.material); number >= 0)
    sleepers.density = physics.materials[static_cast<std::size_t>(number)].density;
  time.rough_step = rough_step_limit(*this);
  time.rough_window = coupling_limit(*this, true).window;
  s.table("time", time, "Time steps.");
}

bool Model::periodic_in(const std::string& axis) const {
  return std::find(periodic.begin(), periodic.end(), axis) != periodic.end();
}

double Model::duration() const {
  double time = 0;
  for (const Stage& stage : stages) time += stage.duration;
  return time;
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
                     [](const Stage& stage) { return has_platen_load(stage.kind); });
}

// There are walls at sides that are not periodic. The floor has the ground's material.
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

// The lattice of `fill` reaches a few times the height of the bed; below z = 0 there is space for
// the settlement of the ground. A stone that leaves the box in z stops the run: so the box is
// large. In a plane model its width is the thickness.
dem::Domain Model::domain() const {
  if (is_placed()) return domain_of_placed(*this);
  dem::Domain domain;
  domain.dimension = dimension;
  domain.thickness = dimension == Dimension::plane ? thickness : 1;
  const bool open = !has_stones();  // no walls are needed then
  domain.periodic = {open || periodic_in("x"),
                     dimension == Dimension::space && (open || periodic_in("y")), false};
  const bool plane = dimension == Dimension::plane;
  domain.low = {bed.x[0], plane ? -thickness / 2 : bed.y[0], -0.2};
  double height = bed.height;
  for (const bed::NamedLayer& layer : bed.layers) height += layer.height;
  domain.high = {bed.x[1], plane ? thickness / 2 : bed.y[1], 10 * height + 1};
  // Stones that leave the floor are removed before they reach the end of this margin.
  double around = bed.beside > 0 ? bed.beside + margin_beside_floor : 0;
  for (const Stage& stage : stages)
    if (stage.confinement > 0)
      around = std::max(around, margin_for_walls * std::max(bed.x[1] - bed.x[0],
                                                            domain.high.y() - domain.low.y()));
  for (int axis = 0; axis < (plane ? 1 : 2); ++axis)
    if (!domain.periodic[static_cast<std::size_t>(axis)])
      domain.low[axis] -= around, domain.high[axis] += around;
  return domain;
}

// In models of placed stones there are no walls besides the placed plates and boxes.
bed::Container Model::container() const {
  bed::Container container = bed.container_in(domain());
  if (is_placed()) container.periodic = {true, true};
  return container;
}

}  // namespace trackbed::model
