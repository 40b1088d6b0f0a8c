// Rules of breakage: which stones can break, and in which stages.
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

// Stones of a library or of a checkpoint may be of either kind.
bool may_be(const Model& model, bool (*of_kind)(bed::StoneKind)) {
  if (!model.start.empty() || !model.bed.cell.empty() || model.is_placed()) return true;
  const auto layers = layers_of(model);
  return std::any_of(layers.begin(), layers.end(), [&](const auto& layer) {
    return (of_kind(layer.stone) || layer.stone == bed::StoneKind::library) &&
           layer.material == model.breakage.material;
  });
}

// Whether the deck itself names a stone with corners.
bool any_corners(const Model& model) {
  using bed::ShapeKind;
  const auto& placed = model.placed.stones;
  if (model.is_placed())
    return std::any_of(placed.begin(), placed.end(), [](const bed::StoneParameters& stone) {
      return stone.shape == ShapeKind::block || stone.shape == ShapeKind::hull ||
             stone.shape == ShapeKind::polyhedron || stone.shape == ShapeKind::compound ||
             stone.shape == ShapeKind::mesh;
    });
  const auto layers = layers_of(model);
  return std::any_of(layers.begin(), layers.end(),
                     [](const auto& layer) { return of_corners(layer.stone); });
}

bool any_compounds(const Model& model) {
  const auto& placed = model.placed.stones;
  if (model.is_placed())
    return std::any_of(placed.begin(), placed.end(), [](const bed::StoneParameters& stone) {
      return stone.shape == bed::ShapeKind::compound;
    });
  const auto layers = layers_of(model);
  return std::any_of(layers.begin(), layers.end(),
                     [](const auto& layer) { return layer.stone == bed::StoneKind::compound; });
}

bool is_clump(bed::StoneKind kind) { return kind == bed::StoneKind::clump; }

// Whether parameters of pebbles alone have their defaults.
bool no_pebbles_given(const dem::BreakageParameters& p) {
  dem::BreakageParameters defaults;
  defaults.material = p.material, defaults.from = p.from, defaults.seed = p.seed;
  defaults.least_size = p.least_size, defaults.check_steps = p.check_steps;
  defaults.splitting = p.splitting, defaults.cutting = p.cutting, defaults.wear = p.wear;
  return p == defaults;
}

// Parameters of a kind of breakage that has no strength.
void declare_idle(const dem::BreakageParameters& p, input::Section& s) {
  const input::About idle{.severity = input::Severity::warning, .reads = {"breakage"}};
  s.rule("breakage.strength", p.of_clumps() || no_pebbles_given(p),
         "no pebbles break off, and the parameters of pebbles (diameter, size_exponent, "
         "weibull, threshold, birth_size, growth_steps, growth_overlap) have no effect",
         idle);
  s.rule("breakage.splitting.strength",
         p.splitting.strength > 0 || p.splitting == dem::SplittingParameters{},
         "no stone splits, and the other parameters of [breakage.splitting] have no effect", idle);
  s.rule("breakage.cutting.strength",
         p.cutting.strength > 0 || p.cutting == dem::CuttingParameters{},
         "no corner is cut, and the other parameters of [breakage.cutting] have no effect", idle);
  s.rule("breakage.wear.coefficient", p.wears() || p.wear == dem::WearParameters{},
         "no stone wears, and the other parameters of [breakage.wear] have no effect", idle);
  const dem::BreakageParameters defaults;
  s.rule("breakage.check_steps", p.of_corners() || p.check_steps == defaults.check_steps,
         "has no effect: only splitting, cutting and wear are checked at intervals", idle);
  s.rule("breakage.seed", p.of_clumps() || p.crushes() || p.seed == defaults.seed,
         "has no effect: wear has no strengths that scatter", idle);
}

}  // namespace

std::size_t Model::stage_of(const std::string& from) const {
  if (is_placed() && from.empty()) return 0;
  for (std::size_t i = 0; i < stages.size(); ++i) {
    const bool loads = stages[i].kind == StageKind::load || stages[i].kind == StageKind::passage;
    if (from.empty() ? loads : stages[i].name == from) return i;
  }
  return stages.size();
}

std::size_t Model::breaks_from() const { return stage_of(breakage.from); }

// Ids of stones that are poured later would follow those of fragments, and depend on how many there
// are.
void declare_breakage(const Model& model, input::Section& s) {
  const dem::BreakageParameters& p = model.breakage;
  if (!p.any()) {
    return s.rule(
        "breakage.strength", p == dem::BreakageParameters{},
        "is 0, as are those of splitting, cutting and wear: nothing breaks, and the other "
        "parameters of [breakage] have no effect",
        {.severity = input::Severity::warning, .reads = {"breakage"}});
  }
  const input::About about{
      .reads = {"breakage", "dimension", model.stones_section(), "material", "start", "stage"}};
  s.rule("breakage", model.dimension == Dimension::space,
         "breakage exists in space only, not in a plane model (dimension)", about);
  s.rule("breakage.strength", !p.of_clumps() || !any_corners(model),
         "must be 0 with stones that have corners: only pebbles of clumps break off (stone = "
         "\"clump\"); give breakage.splitting.strength, breakage.cutting.strength or "
         "breakage.wear.coefficient",
         about);
  s.rule("breakage.wear.coefficient", !p.wears() || !any_compounds(model),
         "must be 0 with compounds: only stones of one polyhedron wear", about);
  model.physics.rule_of_name(s, "breakage.material", p.material);
  const bool known = model.material(p.material) >= 0;
  const input::About unusual{.severity = input::Severity::warning, .reads = about.reads};
  s.rule("breakage.strength", !p.of_clumps() || !known || may_be(model, is_clump),
         fmt::format("there are no clumps of \"{}\": no pebbles break off", p.material), unusual);
  s.rule("breakage.splitting.strength", !p.of_corners() || !known || may_be(model, of_corners),
         fmt::format(
             "there are no polyhedra or compounds of \"{}\": none splits, loses corners or wears",
             p.material),
         unusual);
  declare_idle(p, s);
  const std::size_t from = model.breaks_from();
  s.rule("breakage.from", p.from.empty() || from < model.stages.size(),
         fmt::format("there is no stage \"{}\"", p.from), about);
  s.rule("breakage.from", !p.from.empty() || from < model.stages.size(),
         "nothing breaks: there is no stage of kind load or passage; name the first stage with "
         "breakage (breakage.from)",
         {.severity = input::Severity::warning, .reads = about.reads});
  for (std::size_t i = from; i < model.stages.size(); ++i) {
    const StageKind kind = model.stages[i].kind;
    s.rule(fmt::format("stage[{}].kind", i), kind != StageKind::fill && kind != StageKind::cribs,
           "pours stones after others have begun to break; let them break from a later stage on "
           "(breakage.from)",
           about);
  }
}

}  // namespace trackbed::model
