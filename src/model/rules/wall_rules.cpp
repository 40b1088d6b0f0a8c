// Rules of containers and of the stages that move walls, so that they remain closed boxes on a
// floor.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/rules/rules.hpp"

namespace trackbed::model {

namespace {

constexpr double same_ratio = 1e-9;  // relative

void declare_container(const Model& model, input::Section& s) {
  const bed::BedParameters& bed = model.bed;
  const input::About about{.reads = {"bed", "dimension", "periodic", "stage", "ground.present"}};
  const bool round = bed.container == bed::ContainerKind::cylinder;
  const bool pairs = bed.x.size() == 2 && bed.y.size() == 2;
  const double length = pairs ? bed.x[1] - bed.x[0] : 0, width = pairs ? bed.y[1] - bed.y[0] : 0;
  s.rule("bed.container", !round || model.dimension == Dimension::space,
         "a cylinder needs dimension = \"space\"", about);
  s.rule("bed.container", !round || model.periodic.empty(),
         "a cylinder has walls all around: leave out `periodic`", about);
  s.rule("bed.container", !round || std::abs(length - width) <= same_ratio * length,
         fmt::format("a cylinder needs a square bed, but bed.x is {:g} m and bed.y {:g} m wide",
                     length, width),
         about);
  s.rule("bed.container", !round || !model.uses_sleepers(), "sleepers need a box", about);
  s.rule("bed.split", bed.split < bed.height,
         fmt::format("is not within the bed (bed.height = {:g} m)", bed.height), about);
  s.rule("bed.split", bed.split <= 0 || !model.ground.present,
         "needs a floor that moves with the lower half of the walls: set ground.present = false",
         about);
  s.rule("bed.beside", bed.beside <= 0 || !model.ground.present,
         "needs a floor instead of a ground: set ground.present = false", about);
  s.rule("bed.beside", bed.beside <= 0 || !model.uses_sleepers(),
         "must be 0 in a model with sleepers", about);
}

bool has_walls(const Model& model) {
  return !model.periodic_in("x") ||
         (model.dimension == Dimension::space && !model.periodic_in("y"));
}

// `travel`: m, of the lower half up to the end of the stage.
void declare_shear(const Model& model, std::size_t i, double travel, input::Section& s) {
  const Stage& stage = model.stages[i];
  const std::string kind = fmt::format("stage[{}].kind", i);
  const std::string displacement = fmt::format("stage[{}].displacement", i);
  const input::About about{.reads = {"bed", "periodic", kind, "start"}};
  s.rule(displacement, stage.displacement != 0, "must not be 0 m for a stage of kind shear",
         {.reads = {kind, displacement}});
  s.rule(kind, model.bed.split > 0, "needs divided walls: give bed.split, a height in m", about);
  s.rule(kind, !model.periodic_in("x"), "needs walls normal to x: remove \"x\" from `periodic`",
         about);
  const StageKind before = i > 0 ? model.stages[i - 1].kind : StageKind::compact;
  s.rule(kind, before == StageKind::compact || before == StageKind::shear,
         "needs the platen: the preceding stage must be of kind compact or shear", about);
  s.rule(displacement, std::abs(travel) <= model.bed.beside * (1 + same_ratio),
         fmt::format(
             "moves the lower half of the walls by {:g} m in total, more than bed.beside = {:g} m",
             travel, model.bed.beside),
         about);
}

// Walls with a controlled pressure. Divided walls, and walls on a wider floor, would leave gaps.
void declare_confinement(const Model& model, std::size_t i, input::Section& s) {
  const Stage& stage = model.stages[i];
  const std::string key = fmt::format("stage[{}].confinement", i);
  const std::string kind = fmt::format("stage[{}].kind", i);
  const input::About about{.reads = {"bed", "periodic", key, kind}};
  const bool triaxial = stage.kind == StageKind::triaxial;
  s.rule(key, stage.confinement <= 0 || triaxial || stage.kind == StageKind::compact,
         "is for stages of kind compact and triaxial only", {.reads = {key, kind}});
  s.rule(key, !triaxial || stage.confinement > 0, "must be above 0 Pa for a stage of kind triaxial",
         {.reads = {key, kind}});
  if (stage.confinement <= 0) return;
  s.rule(key, has_walls(model), "needs walls, but all sides are periodic", about);
  s.rule(key, model.bed.container == bed::ContainerKind::box, "needs the walls of a box", about);
  s.rule(key, model.bed.split <= 0 && model.bed.beside <= 0,
         "needs undivided walls at the edge of the floor: leave out bed.split and bed.beside",
         about);
}

void declare_triaxial(const Model& model, std::size_t i, input::Section& s) {
  const Stage& stage = model.stages[i];
  const std::string kind = fmt::format("stage[{}].kind", i);
  const std::string displacement = fmt::format("stage[{}].displacement", i);
  const input::About about{.reads = {kind, displacement, "bed.height"}};
  s.rule(displacement, stage.displacement != 0, "must not be 0 m for a stage of kind triaxial",
         about);
  s.rule(displacement, stage.displacement < model.bed.height,
         fmt::format("must be below the height of the bed ({:g} m)", model.bed.height), about);
  const bool first = i == 0 && model.start.empty();
  s.rule(kind, !first && (i == 0 || has_platen_load(model.stages[i - 1].kind)),
         "needs the platen: the preceding stage must be of kind compact or triaxial",
         {.reads = {kind, fmt::format("stage[{}].kind", i > 0 ? i - 1 : 0), "start"}});
}

void declare_lift(const Model& model, std::size_t i, input::Section& s) {
  const Stage& stage = model.stages[i];
  const std::string kind = fmt::format("stage[{}].kind", i);
  const input::About about{.reads = {"bed", "periodic", kind}};
  s.rule(kind, has_walls(model), "needs walls, but all sides are periodic", about);
  s.rule(kind, model.bed.beside > 0, "needs floor around the walls: give bed.beside in m", about);
  s.rule(kind, model.bed.split <= 0, "needs undivided walls: leave out bed.split", about);
  s.rule(
      fmt::format("stage[{}].lift", i), stage.lift * stage.duration >= model.bed.height,
      fmt::format("lifts the walls by {:g} m before they are removed, less than the height of the "
                  "bed ({:g} m)",
                  stage.lift * stage.duration, model.bed.height),
      {.severity = input::Severity::warning, .reads = {"bed.height", "stage"}});
}

}  // namespace

void declare_walls(const Model& model, input::Section& s) {
  declare_container(model, s);
  bool moved = false;
  double travel = 0;  // m, of the lower half
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const Stage& stage = model.stages[i];
    const bool shears = stage.kind == StageKind::shear;
    const bool compacts = stage.kind == StageKind::compact;
    travel += shears ? stage.displacement : 0;
    const bool triaxial = stage.kind == StageKind::triaxial;
    if (shears) declare_shear(model, i, travel, s);
    if (triaxial) declare_triaxial(model, i, s);
    declare_confinement(model, i, s);
    if (stage.kind == StageKind::lift_walls) declare_lift(model, i, s);
    s.rule(fmt::format("stage[{}].kind", i), !moved || stage.kind != StageKind::fill,
           "fills stones into walls that an earlier stage has moved, which is not possible",
           {.reads = {"stage"}});
    const auto only = [&](const char* name, bool holds, const char* words) {
      const std::string key = fmt::format("stage[{}].{}", i, name);
      s.rule(key, holds, words, {.reads = {key, fmt::format("stage[{}].kind", i)}});
    };
    only("displacement", shears || triaxial || stage.displacement == 0,
         "is for stages of kind shear and triaxial only");
    only("pressure", shears || compacts || stage.pressure == 0,
         "is for stages of kind compact and shear only");
    moved = moved || shears || stage.kind == StageKind::lift_walls || stage.confinement > 0;
  }
}

}  // namespace trackbed::model
