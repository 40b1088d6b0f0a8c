// Rules of the order of stages and of the parameters that each kind uses; names that become names
// of files and of groups in results.
//
// An impossible order is an error; a parameter that its stage does not use gives a warning: most
// often it was meant for another stage.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "model/rules/rules.hpp"

namespace trackbed::model {

namespace {

// For names of checkpoints and of groups in HDF5 files: accepted by every file system and shell.
bool is_a_word(const std::string& name) {
  constexpr std::size_t longest = 100;
  const bool plain = std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '+' || c == '.';
  });
  return plain && !name.empty() && name.size() <= longest && name.front() != '.' &&
         name.front() != '-';
}

constexpr const char* word_wanted =
    "must be a word of letters, digits and the characters '_', '-', '+' and '.' (at most 100 "
    "characters, not beginning with '.' or '-'): it is used in overrides and in names of files and "
    "groups of the results";

// Each a word, all different.
void declare_names(const std::string& list, const std::string& plural, const auto& tables,
                   const input::About& about, input::Section& s) {
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const auto end = tables.begin() + static_cast<std::ptrdiff_t>(i);
    const auto same = std::find_if(tables.begin(), end,
                                   [&](const auto& one) { return one.name == tables[i].name; });
    s.rule(fmt::format("{}[{}].name", list, i), same == end,
           fmt::format("is also the name of {}[{}]: {} need different names", list,
                       same - tables.begin(), plural),
           about);
  }
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const std::string key = fmt::format("{}[{}].name", list, i);
    s.rule(key, is_a_word(tables[i].name), word_wanted, {.reads = {key}});
  }
}

// What each stage requires of earlier ones. After a start from a checkpoint these may have been
// done before: the file is read later.
void declare_order(const Model& model, input::Section& s) {
  input::About about{.reads = {"start"}};  // and all kinds, since the rules depend on all of them
  for (std::size_t i = 0; i < model.stages.size(); ++i)
    about.reads.push_back(fmt::format("stage[{}].kind", i));
  bool placed = !model.start.empty(), pressed = placed;
  std::string placed_by;
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const StageKind kind = model.stages[i].kind;
    const std::string key = fmt::format("stage[{}].kind", i);
    const bool loads =
        kind == StageKind::load || kind == StageKind::passage || kind == StageKind::tamp;
    s.rule(key, placed || kind == StageKind::sleepers || (!loads && kind != StageKind::cribs),
           "needs sleepers, but no stage of kind sleepers comes before it", about);
    s.rule(key, kind != StageKind::sleepers || placed_by.empty(),
           fmt::format("places sleepers, which stage \"{}\" has already placed", placed_by), about);
    s.rule(key, kind != StageKind::fill || placed_by.empty(),
           fmt::format("pours stones onto sleepers, which stage \"{}\" has placed; to fill between "
                       "them use a stage of kind cribs",
                       placed_by),
           about);
    s.rule(key, kind != StageKind::release || pressed,
           "lifts a platen, but no stage of kind compact comes before it", about);
    placed = placed || kind == StageKind::sleepers;
    pressed = pressed || kind == StageKind::compact;
    if (kind == StageKind::sleepers && placed_by.empty()) placed_by = model.stages[i].name;
  }
}

// Softer contacts are for stones that carry little more than themselves. In a bed that has been
// loaded, stresses stay; stones that become soft settle into another packing, and stones that
// become stiff are launched.
void declare_stiffness(const Model& model, input::Section& s) {
  bool only_poured = model.has_bed() && model.bed.cell.empty();
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const Stage& stage = model.stages[i];
    const std::string key = fmt::format("stage[{}].stiffness", i);
    only_poured = only_poured && (stage.kind == StageKind::fill || stage.kind == StageKind::settle);
    s.rule(key, stage.stiffness == 1 || (only_poured && !stage.ground_moves),
           "must be 1: softer contacts are for stages of kind fill and settle of a bed that has "
           "not been loaded yet, without bed.cell, above ground that does not move",
           {.reads = {key, "stage", "bed.cell"}});
    s.rule(key, stage.stiffness == 1 || model.time.step == 0,
           "makes no sub-step longer, since time.step is given; leave time.step out",
           {.severity = input::Severity::warning, .reads = {key, "time.step"}});
  }
}

}  // namespace

// Parameters that only some kinds use, compared with their defaults.
void declare_uses_of_stages(const Model& model, input::Section& s) {
  using enum StageKind;
  const Stage none;
  bool placed = !model.start.empty();  // sleepers
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const Stage& stage = model.stages[i];
    const auto only = [&](const char* name, bool given, std::initializer_list<StageKind> kinds,
                          const char* words) {
      const bool used = std::find(kinds.begin(), kinds.end(), stage.kind) != kinds.end();
      const std::string key = fmt::format("stage[{}].{}", i, name);
      s.rule(
          key, used || !given, fmt::format("has no effect: it is for {}", words),
          {.severity = input::Severity::warning, .reads = {key, fmt::format("stage[{}].kind", i)}});
    };
    only("lift", stage.lift != none.lift, {release, lift_walls},
         "stages of kind release and lift_walls");
    only("height", stage.height != none.height, {sleepers}, "stages of kind sleepers");
    only("growth", stage.growth != none.growth, {fill}, "stages of kind fill");
    const std::string growth = fmt::format("stage[{}].growth", i);
    s.rule(growth, model.bed.cell.empty() || stage.growth == 0,
           "must be 0 with bed.cell, whose copies are already packed",
           {.reads = {growth, "bed.cell"}});
    constexpr double fewest = 20;  // sub-steps, in which stones still move apart
    const double step = (model.time.step > 0 ? model.time.step : model.time.rough_step) /
                        std::sqrt(stage.stiffness);
    s.rule(
        growth, stage.growth == 0 || step == input::unbounded || stage.growth >= fewest * step,
        fmt::format("is less than {:.0f} sub-steps of about {:.2g} s, so that stones would overlap "
                    "deeply; give at least {:.2g} s",
                    fewest, step, fewest * step),
        {.reads = {growth, fmt::format("stage[{}].stiffness", i), "bed", "time.step", "dem.safety",
                   "contact", "material"}});
    const std::string growth_height = growth + "_height";
    s.rule(growth_height, stage.growth_height == none.growth_height || stage.growth > 0,
           "has no effect: the stage has no growth",
           {.severity = input::Severity::warning, .reads = {growth, growth_height}});
    only("load", stage.load != none.load, {load, jump}, "stages of kind load and jump");
    only("ramp", stage.ramp != none.ramp, {load, compact, shear, triaxial, passage},
         "stages of kind load, compact, shear, triaxial and passage");
    only("until_ratio", stage.until_ratio != none.until_ratio,
         {fill, settle, compact, release, sleepers, cribs, run, lift_walls, tamp},
         "all kinds of stages except load, passage, shear and triaxial");
    placed = placed || stage.kind == sleepers;
    s.rule(fmt::format("stage[{}].seat_force", i),
           stage.seat_force == none.seat_force || (placed && stage.kind != tamp),
           "has no effect: it acts on sleepers that are placed in this stage or before, and not "
           "while they are lifted (stages of kind tamp)",
           {.severity = input::Severity::warning, .reads = {"stage", "start"}});
  }
}

namespace {

// m, of all layers.
double height_of(const bed::BedParameters& bed) {
  double height = bed.height;
  for (const bed::NamedLayer& layer : bed.layers) height += layer.height;
  return height;
}

// Heights in mm would put the profile or the sleepers far above the bed.
void declare_heights(const Model& model, input::Section& s) {
  constexpr double beyond = 3;  // heights of the bed: loose stones and sleepers reach less
  const double bed = height_of(model.bed);
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const Stage& stage = model.stages[i];
    const bool places = stage.kind == StageKind::sleepers;
    for (const auto& [name, height] :
         {std::pair{"height", places ? stage.height : 0}, {"profile", stage.profile}}) {
      const std::string key = fmt::format("stage[{}].{}", i, name);
      s.rule(key, height <= beyond * bed,
             fmt::format("is far above the bed, which is {:g} m high (more than {:g} times its "
                         "height); is it in m?",
                         bed, beyond),
             {.reads = {key, "bed"}});
    }
    // Beds have the height given in the deck to within about a tenth.
    constexpr double above = 1.2;
    const std::string sleepers = fmt::format("stage[{}].height", i);
    s.rule(sleepers, !places || !(stage.height > above * bed) || stage.height > beyond * bed,
           fmt::format("puts the sleepers above the bed, which is about {:g} m high (more than "
                       "{:g} times its height)",
                       bed, above),
           {.severity = input::Severity::warning, .reads = {sleepers, "bed"}});
    const bool fills_later =
        std::any_of(model.stages.begin() + static_cast<std::ptrdiff_t>(i), model.stages.end(),
                    [](const Stage& later) { return later.kind == StageKind::cribs; });
    constexpr double least = 0.25;  // of the height of the sleepers
    s.rule(fmt::format("stage[{}].profile", i),
           !places || fills_later || stage.profile == 0 ||
               stage.profile >= stage.height + least * model.sleepers.height,
           fmt::format("{} (height = {:g} m): it removes the ballast {}; the top of the sleepers "
                       "is at {:.4g} m",
                       stage.profile < stage.height ? "is below the lower faces of the sleepers"
                                                    : "is hardly above the lower faces of the "
                                                      "sleepers",
                       stage.height, stage.profile < stage.height ? "below them" : "between them",
                       stage.height + model.sleepers.height),
           {.severity = input::Severity::warning,
            .reads = {sleepers, fmt::format("stage[{}].profile", i), "sleepers"}});
    const double stone = model.bed.sieve.empty() ? 0 : 1e-3 * model.bed.sieve.back();  // mm
    const std::string key = fmt::format("stage[{}].height", i);
    s.rule(key, !places || stage.height == 0 || stage.height >= stone,
           fmt::format("puts the lower faces of the sleepers too low: less than the size of the "
                       "largest stone ({:.3g} m) above z = 0",
                       stone),
           {.severity = input::Severity::warning, .reads = {key, "bed"}});
  }
}

// The axis along which a region does not intersect the bed, and a description; empty if it does.
struct Apart {
  const char* axis = "x";
  std::string words;
};

Apart beside_the_bed(const Model& model, const observe::Region& region) {
  const bool ball = region.kind == observe::RegionKind::sphere;
  const auto range = [&](std::size_t axis, const std::vector<double>& given) {
    return ball
               ? std::pair{region.centre[axis] - region.radius, region.centre[axis] + region.radius}
               : std::pair{given[0], given[1]};
  };
  const auto apart = [&](std::size_t axis, const auto& given, const auto& bed) {
    const auto [low, high] = range(axis, given);
    return low >= bed[1] || high <= bed[0];
  };
  const auto& bed = model.bed;
  if (!model.periodic_in("x") && apart(0, region.x, bed.x))
    return {"x", fmt::format("is beside the bed (bed.x: {:g} to {:g} m)", bed.x[0], bed.x[1])};
  const bool space = model.dimension == Dimension::space;
  if (space && !model.periodic_in("y") && apart(1, region.y, bed.y))
    return {"y", fmt::format("is beside the bed (bed.y: {:g} to {:g} m)", bed.y[0], bed.y[1])};
  // The ground may settle; sleepers and heaps are higher than the bed.
  const double height = height_of(bed);
  if (apart(2, region.z, std::array{-0.1 * height, 2 * height}))
    return {"z", fmt::format("is below or above the bed, which is {:g} m high", height)};
  return {};
}

// The axis along which a box reaches beyond existing walls, or empty. Heaps may be beyond them.
std::string_view sticks_out(const Model& model, const observe::Region& region) {
  if (region.kind == observe::RegionKind::sphere || model.bed.beside > 0) return {};
  const auto beyond = [](const auto& box, const std::vector<double>& bed) {
    return box[0] < bed[0] - 1e-9 || box[1] > bed[1] + 1e-9;
  };
  if (!model.periodic_in("x") && beyond(region.x, model.bed.x)) return "x";
  const bool space = model.dimension == Dimension::space;
  if (space && !model.periodic_in("y") && beyond(region.y, model.bed.y)) return "y";
  return {};
}

// Where a place is outside of a ground of boxes, or empty.
std::string outside_of_layers(const Model& model, const std::vector<double>& at) {
  const fem::GroundParameters& ground = model.ground;
  if (ground.of_tetrahedra() || at.size() != 3 || ground.x.size() != 2 || ground.y.size() != 2)
    return "";
  double depth = 0;
  for (const fem::Layer& layer : ground.layers) depth += layer.thickness;
  const auto beyond = [&](std::size_t axis, const char* name, double low, double high) {
    return at[axis] >= low && at[axis] <= high
               ? std::string()
               : fmt::format("is outside of the ground ({}: {:g} to {:g} m)", name, low, high);
  };
  std::string words = beyond(0, "x", ground.x[0], ground.x[1]);
  if (words.empty() && model.dimension == Dimension::space)
    words = beyond(1, "y", ground.y[0], ground.y[1]);
  return words.empty() ? beyond(2, "z", -depth, 0) : words;
}

}  // namespace

// Checkpoints, overrides and a start refer to stages by name.
void declare_names_of_stages(const Model& model, input::Section& s) {
  const auto& stages = model.stages;
  const input::About about{.reads = {"stage", "start"}};
  s.rule("stage", !stages.empty(), "at least one [[stage]] is needed", about);
  declare_names("stage", "stages", stages, about, s);
}

// Overrides and messages refer to them by name.
void declare_names_of_pressures(const Model& model, input::Section& s) {
  declare_names("pressure", "pressures", model.pressures, {.reads = {"pressure"}}, s);
}

void declare_names_of_bonds(const Model& model, input::Section& s) {
  declare_names("bond", "bonds", model.bonds, {.reads = {"bond"}}, s);
}

// Their names are groups of the results. Plates and boxes are both surfaces.
void declare_names_of_placed(const Model& model, input::Section& s) {
  const PlacedParameters& placed = model.placed;
  declare_names("stone", "stones", placed.stones, {.reads = {"stone"}}, s);
  declare_names("plate", "plates", placed.plates, {.reads = {"plate"}}, s);
  declare_names("box", "boxes", placed.boxes, {.reads = {"box"}}, s);
  const auto differ = [&](const char* list, const auto& tables, const char* other,
                          const auto& others) {
    for (std::size_t i = 0; i < tables.size(); ++i)
      s.rule(fmt::format("{}[{}].name", list, i),
             std::none_of(others.begin(), others.end(),
                          [&](const auto& one) { return one.name == tables[i].name; }),
             fmt::format("is also the name of a [[{}]]; give another name", other),
             {.reads = {list, other}});
  };
  differ("plate", placed.plates, "stone", placed.stones);
  differ("box", placed.boxes, "stone", placed.stones);
  differ("box", placed.boxes, "plate", placed.plates);
}

void declare_stages(const Model& model, input::Section& s) {
  const auto& stages = model.stages;
  declare_names_of_stages(model, s);
  s.rule("stage", stages.empty() || stages[0].kind == StageKind::fill || !model.start.empty(),
         "the first stage must be of kind fill, or `start` must name a checkpoint",
         {.reads = {"stage", "start"}});
  declare_order(model, s);
  declare_stiffness(model, s);
  declare_uses_of_stages(model, s);
  declare_heights(model, s);
  const bool any = model.has_stage(StageKind::sleepers) || model.has_stage(StageKind::load) ||
                   model.has_stage(StageKind::passage) || model.has_stage(StageKind::tamp);
  s.rule("sleepers.count", !any || model.sleepers.count > 0,
         "must be at least 1, since stages place or load sleepers",
         {.reads = {"sleepers.count", "stage"}});
}

constexpr double most_periods = 10;  // of a region

// Names of regions are groups of the results. A region beside the bed would always be empty.
void declare_regions(const Model& model, input::Section& s) {
  declare_names("region", "regions", model.regions, {.reads = {"region"}}, s);
  for (std::size_t i = 0; i < model.regions.size(); ++i) {
    const observe::Region& region = model.regions[i];
    const std::string key = fmt::format("region[{}]", i);
    if (model.bed.x.size() != 2 || model.bed.y.size() != 2) continue;
    const Apart apart = beside_the_bed(model, region);
    const bool ball = region.kind == observe::RegionKind::sphere;
    s.rule(fmt::format("{}.{}", key, ball ? "centre" : apart.axis), apart.words.empty(),
           apart.words, {.reads = {key, "bed", "dimension", "periodic"}});
    for (const auto& [name, given, extent] :
         {std::tuple{"x", &region.x, &model.bed.x}, {"y", &region.y, &model.bed.y}}) {
      const double length = ball ? 2 * region.radius : (*given)[1] - (*given)[0];
      const double period = (*extent)[1] - (*extent)[0];
      s.rule(fmt::format("{}.{}", key, ball ? "radius" : name),
             !model.periodic_in(name) || length <= most_periods * period,
             fmt::format("extends over more than {:g} periods of the bed along {}, of {:g} m each: "
                         "each of them is measured",
                         most_periods, name, period),
             {.reads = {key, "bed", "dimension", "periodic"}});
    }
    const std::string_view axis = sticks_out(model, region);
    s.rule(fmt::format("{}.{}", key, axis.empty() ? "x" : axis),
           axis.empty() || !apart.words.empty(),
           "reaches beyond the bed: the volume outside counts as voids",
           {.severity = input::Severity::warning, .reads = {key, "bed", "dimension", "periodic"}});
  }
}

// Each of `names` that is not empty is that of a stage.
void declare_stage_names(const Model& model, const std::string& key,
                         const std::vector<std::string>& names, const input::About& about,
                         input::Section& s) {
  std::vector<std::string> known{""};
  for (const Stage& stage : model.stages) known.push_back(stage.name);
  for (const std::string& name : names)
    s.rule(key, std::find(known.begin(), known.end(), name) != known.end(),
           fmt::format("\"{}\" is none of the stages: {}", name,
                       fmt::join(known.begin() + 1, known.end(), ", ")),
           about);
}

void declare_fields(const Model& model, input::Section& s) {
  declare_stage_names(model, "output.fields_stages", model.output.fields_stages,
                      {.reads = {"output.fields_stages", "stage"}}, s);
}

// The elements of embankments and mesh files are searched when the ground is made.
void declare_sensors(const Model& model, input::Section& s) {
  declare_names("sensor", "sensors", model.sensors, {.reads = {"sensor"}}, s);
  for (std::size_t i = 0; i < model.sensors.size(); ++i) {
    const observe::Sensor& sensor = model.sensors[i];
    const std::string key = fmt::format("sensor[{}]", i);
    const bool in_ground = sensor.kind == observe::SensorKind::ground;
    s.rule(key + ".kind", !in_ground || model.ground.present,
           "is a point of the ground, but the model has none", {.reads = {key, "ground"}});
    s.rule(key + ".kind", in_ground || model.has_stones(),
           "must be \"ground\": the model has no stones", {.reads = {key}});
    if (in_ground) {
      const std::string outside = outside_of_layers(model, sensor.at);
      s.rule(key + ".at", outside.empty(), outside, {.reads = {key, "ground", "dimension"}});
      continue;
    }
    declare_stage_names(model, key + ".stage", {sensor.stage}, {.reads = {key, "stage"}}, s);
    if (sensor.at.size() != 3 || model.bed.x.size() != 2 || model.bed.y.size() != 2) continue;
    observe::Region around;
    around.kind = observe::RegionKind::sphere;
    around.centre = sensor.at;
    around.radius = std::max(sensor.radius, 1e-9);
    const Apart apart = beside_the_bed(model, around);
    s.rule(key + ".at", apart.words.empty(), apart.words,
           {.reads = {key, "bed", "dimension", "periodic"}});
  }
}

}  // namespace trackbed::model
