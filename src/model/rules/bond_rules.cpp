// Rules of bonds: where and when they are made.
#include <fmt/format.h>

#include <algorithm>

#include "model/rules/rules.hpp"

namespace trackbed::model {

namespace {

void declare_box(const dem::BondParameters& bond, const std::string& key, bool plane,
                 input::Section& s) {
  const input::About about{.reads = {key, "dimension"}};
  const bool both = bond.low.size() == 3 && bond.high.size() == 3;
  s.rule(key + ".low", both || (bond.low.empty() && bond.high.empty()),
         "needs both corners of the box, low and high, with three numbers each, or none of them",
         about);
  for (std::size_t a = 0; both && a < 3; ++a)
    s.rule(key + ".high", bond.low[a] < bond.high[a] || (plane && a == 1),
           fmt::format("must be above `low` along {}", "xyz"[a]), about);
}

bool has_balls(bed::StoneKind kind) {
  return kind != bed::StoneKind::polyhedra && kind != bed::StoneKind::compound;
}
bool has_balls(bed::ShapeKind shape) {
  using enum bed::ShapeKind;
  return shape == ball || shape == clump || shape == library;
}

// Whether there may be any.
bool any_balls(const Model& model) {
  if (!model.start.empty() || !model.bed.cell.empty()) return true;
  const auto& placed = model.placed.stones;
  if (model.is_placed())
    return std::any_of(placed.begin(), placed.end(),
                       [](const auto& stone) { return has_balls(stone.shape); });
  const auto& layers = model.bed.layers;
  return has_balls(model.bed.stone) ||
         std::any_of(layers.begin(), layers.end(),
                     [](const auto& layer) { return has_balls(layer.stone); });
}

}  // namespace

std::size_t Model::bonds_from(std::size_t kind) const { return stage_of(bonds[kind].from); }

void declare_bonds(const Model& model, input::Section& s) {
  if (model.bonds.empty()) return;
  declare_names_of_bonds(model, s);
  const bool any = std::any_of(model.bonds.begin(), model.bonds.end(),
                               [](const dem::BondParameters& bond) { return bond.present; });
  s.rule("bond", !any || !model.breakage.any(),
         "is not possible with stones that break: leave out [breakage] or the [[bond]]",
         {.reads = {"bond", "breakage"}});
  for (std::size_t i = 0; i < model.bonds.size(); ++i) {
    const dem::BondParameters& bond = model.bonds[i];
    const std::string key = fmt::format("bond[{}]", i);
    const input::About about{.reads = {key, "stage", "start"}};
    s.rule(key + ".gap", bond.gap == 0 || any_balls(model),
           "has no effect: there are no balls, and stones with corners are bonded where they touch",
           {.severity = input::Severity::warning,
            .reads = {key, model.stones_section(), "start", "dimension"}});
    declare_box(bond, key, model.dimension == Dimension::plane, s);
    if (!bond.material.empty()) model.physics.rule_of_name(s, key + ".material", bond.material);
    const std::size_t from = model.bonds_from(i);
    const bool known = from < model.stages.size();
    s.rule(key + ".from", bond.from.empty() || known,
           fmt::format("there is no stage \"{}\"", bond.from), about);
    s.rule(key + ".from", !bond.from.empty() || known,
           "no bonds are made: there is no stage of kind load or passage; name the stage at whose "
           "begin they are made",
           {.severity = input::Severity::warning, .reads = about.reads});
    s.rule(key + ".from", !known || model.stages[from].kind != StageKind::fill,
           "is a stage of kind fill, at whose begin stones are only being made; name a later one",
           about);
  }
}

}  // namespace trackbed::model
