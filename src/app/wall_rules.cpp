// Rules of containers and of the stages that move walls: what they need to be closed boxes that
// stand on a floor.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/rules.hpp"

namespace trackbed::app {

namespace {

constexpr double rounding = 1e-9;  // relative

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
  s.rule("bed.container", !round || std::abs(length - width) <= rounding * length,
         fmt::format("a cylinder needs a square bed, but bed.x is {:g} m and bed.y {:g} m wide",
                     length, width),
         about);
  s.rule("bed.container", !round || !model.uses_sleepers(), "sleepers need a box", about);
  s.rule("bed.split", bed.split < bed.height,
         fmt::format("is not within the bed (bed.height = {:g} m)", bed.height), about);
  s.rule("bed.split", bed.split <= 0 || !model.ground.present,
         "divided walls need a floor that moves with the lower half: set ground.present = false",
         about);
  s.rule("bed.beside", bed.beside <= 0 || !model.ground.present,
         "is floor, but there is a ground: set ground.present = false", about);
  s.rule("bed.beside", bed.beside <= 0 || !model.uses_sleepers(), "is for beds without sleepers",
         about);
}

bool has_walls(const Model& model) {
  return !model.periodic_in("x") ||
         (model.dimension == Dimension::space && !model.periodic_in("y"));
}

void declare_shear(const Model& model, std::size_t i, double way, input::Section& s) {
  const Stage& stage = model.stages[i];
  const std::string kind = fmt::format("stage[{}].kind", i);
  const std::string displacement = fmt::format("stage[{}].displacement", i);
  const input::About about{.reads = {"bed", "periodic", kind, "start"}};
  s.rule(displacement, stage.displacement != 0, "must not be 0 m for a stage of kind shear",
         {.reads = {kind, displacement}});
  s.rule(kind, model.bed.split > 0, "needs divided walls: give bed.split, a height in m", about);
  s.rule(kind, !model.periodic_in("x"), "needs walls along x: leave out \"x\" of `periodic`",
         about);
  const StageKind before = i > 0 ? model.stages[i - 1].kind : StageKind::compact;
  s.rule(kind, before == StageKind::compact || before == StageKind::shear,
         "needs the platen: the stage before must be of kind compact or shear", about);
  s.rule(displacement, std::abs(way) <= model.bed.beside * (1 + rounding),
         fmt::format("takes the lower half {:g} m away, further than bed.beside = {:g} m", way,
                     model.bed.beside),
         about);
}

void declare_lift(const Model& model, std::size_t i, input::Section& s) {
  const Stage& stage = model.stages[i];
  const std::string kind = fmt::format("stage[{}].kind", i);
  const input::About about{.reads = {"bed", "periodic", kind}};
  s.rule(kind, has_walls(model), "there are no walls: all sides are periodic", about);
  s.rule(kind, model.bed.beside > 0, "needs floor around the walls: give bed.beside, m", about);
  s.rule(kind, model.bed.split <= 0, "lifts whole walls: leave out bed.split", about);
  s.rule(fmt::format("stage[{}].lift", i), stage.lift * stage.duration >= model.bed.height,
         fmt::format("lifts the walls by {:g} m before they go, less than the bed is high ({:g} m)",
                     stage.lift * stage.duration, model.bed.height),
         {.weight = input::Weight::warning, .reads = {"bed.height", "stage"}});
}

}  // namespace

void declare_walls(const Model& model, input::Section& s) {
  declare_container(model, s);
  bool moved = false;
  double way = 0;  // m, of the lower half
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const Stage& stage = model.stages[i];
    const bool shears = stage.kind == StageKind::shear;
    const bool compacts = stage.kind == StageKind::compact;
    way += shears ? stage.displacement : 0;
    if (shears) declare_shear(model, i, way, s);
    if (stage.kind == StageKind::lift_walls) declare_lift(model, i, s);
    s.rule(fmt::format("stage[{}].kind", i), !moved || stage.kind != StageKind::fill,
           "stones cannot be filled into walls that a stage before has moved",
           {.reads = {"stage"}});
    const auto only = [&](const char* name, bool holds, const char* words) {
      const std::string key = fmt::format("stage[{}].{}", i, name);
      s.rule(key, holds, words, {.reads = {key, fmt::format("stage[{}].kind", i)}});
    };
    only("displacement", shears || stage.displacement == 0, "is for stages of kind shear only");
    only("pressure", shears || compacts || stage.pressure == 0,
         "is for stages of kind compact and shear only");
    moved = moved || shears || stage.kind == StageKind::lift_walls;
  }
}

}  // namespace trackbed::app
