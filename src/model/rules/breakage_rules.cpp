// Rules of the breakage of corners: which stones can break, and in which stages.
#include <fmt/format.h>

#include <algorithm>

#include "model/rules/rules.hpp"

namespace trackbed::model {

namespace {

// All layers of the bed.
std::vector<bed::LayerParameters> layers_of(const Model& model) {
  std::vector<bed::LayerParameters> layers{model.bed};
  layers.insert(layers.end(), model.bed.layers.begin(), model.bed.layers.end());
  return layers;
}

bool of_corners(bed::StoneKind kind) {
  return kind == bed::StoneKind::polyhedra || kind == bed::StoneKind::compound;
}

bool any_corners(const Model& model) {
  const auto layers = layers_of(model);
  return std::any_of(layers.begin(), layers.end(),
                     [](const auto& layer) { return of_corners(layer.stone); });
}

// Stones of a library or of a checkpoint may be clumps.
bool any_clump(const Model& model) {
  if (!model.start.empty() || !model.bed.cell.empty()) return true;
  const auto layers = layers_of(model);
  return std::any_of(layers.begin(), layers.end(), [&](const auto& layer) {
    const bool clump =
        layer.stone == bed::StoneKind::clump || layer.stone == bed::StoneKind::library;
    return clump && layer.material == model.breakage.material;
  });
}

}  // namespace

std::size_t Model::breaks_from() const {
  for (std::size_t i = 0; i < stages.size(); ++i) {
    const bool loads = stages[i].kind == StageKind::load || stages[i].kind == StageKind::passage;
    if (breakage.from.empty() ? loads : stages[i].name == breakage.from) return i;
  }
  return stages.size();
}

// Ids of stones that are poured later would follow those of fragments, and depend on how many there
// are.
void declare_breakage(const Model& model, input::Section& s) {
  const dem::BreakageParameters& p = model.breakage;
  if (p.strength == 0) {
    const auto text = [](dem::BreakageParameters of) {
      of.strength = 0;
      return input::effective([&of](input::Section& inner) { of.declare(inner); });
    };
    return s.rule("breakage.strength", text(p) == text({}),
                  "is 0: nothing breaks, and the other parameters of [breakage] have no effect",
                  {.severity = input::Severity::warning, .reads = {"breakage"}});
  }
  const input::About about{
      .reads = {"breakage", "dimension", "bed", "stone", "material", "start", "stage"}};
  s.rule("breakage.strength", model.dimension == Dimension::space,
         "must be 0 in a plane model: only corners of clumps in space break (dimension)", about);
  s.rule("breakage.strength", !any_corners(model),
         "must be 0 with stones that have corners: only pebbles of clumps break off (stone = "
         "\"clump\")",
         about);
  model.physics.rule_of_name(s, "breakage.material", p.material);
  s.rule("breakage.material", model.material(p.material) < 0 || any_clump(model),
         fmt::format("there are no clumps of \"{}\": nothing breaks", p.material),
         {.severity = input::Severity::warning, .reads = about.reads});
  const std::size_t from = model.breaks_from();
  s.rule("breakage.from", p.from.empty() || from < model.stages.size(),
         fmt::format("there is no stage \"{}\"", p.from), about);
  s.rule("breakage.strength", !p.from.empty() || from < model.stages.size(),
         "has no effect: there is no stage of kind load or passage; name the first stage with "
         "breakage (breakage.from)",
         {.severity = input::Severity::warning, .reads = about.reads});
  for (std::size_t i = from; i < model.stages.size(); ++i) {
    const StageKind kind = model.stages[i].kind;
    s.rule(fmt::format("stage[{}].kind", i), kind != StageKind::fill && kind != StageKind::cribs,
           "pours stones after corners have begun to break; let them break from a later stage on "
           "(breakage.from)",
           about);
  }
}

}  // namespace trackbed::model
