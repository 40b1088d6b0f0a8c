// The rules of postproc/trackbed_post/ground_blocks.py, which judges finished runs: unless the deck
// states a role, a structure is stiff and deep, all other blocks are measures. Sleepers at the ends
// of the bed are not judged. Where rail and ground have changed is known only after a run; so plain
// track may begin later than stated here.
#include "model/check/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

namespace trackbed::model {

namespace {

constexpr double stiff_as_structure = 10e9;  // Pa, least Young's modulus of a structure
constexpr double deep = 0.5;                 // of the depth of the ground
constexpr double tiny = 1e-9;                // m
constexpr std::size_t ends_on_springs = 3, ends_at_walls = 1;  // sleepers that are not judged
constexpr double behind = 2;    // spacings, from the last change to plain track
constexpr std::size_t few = 2;  // sleepers that each part needs

struct Extent {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void add(double value) { low = std::min(low, value), high = std::max(high, value); }
};

struct Outline {
  Extent x, z;
  bool stiff = false, structural = false;
  explicit Outline(const fem::Block& block)
      : stiff(block.present && block.role == fem::BlockRole::automatic &&
              block.solid.young >= stiff_as_structure),
        structural(block.present && block.role == fem::BlockRole::structure) {
    for (std::size_t k = 0; k + 1 < block.outline.size(); k += 2)
      x.add(block.outline[k]), z.add(block.outline[k + 1]);
  }
  bool stands_on(const Outline& lower) const {
    const double common = std::min(x.high, lower.x.high) - std::max(x.low, lower.x.low);
    return z.low - tiny <= lower.z.high && lower.z.high < z.high - tiny &&
           common >= (x.high - x.low) / 2 - tiny;
  }
};

// A block and the stiff ones on which it stands.
std::vector<Outline*> column_below(Outline& top, std::vector<Outline>& blocks) {
  std::vector<Outline*> column = {&top};
  for (std::size_t k = 0; k < column.size(); ++k)
    for (Outline& lower : blocks)
      if (lower.stiff && column[k]->stands_on(lower) &&
          std::find(column.begin(), column.end(), &lower) == column.end())
        column.push_back(&lower);
  return column;
}

struct Parts {
  Extent structure;             // m
  double edge = 0;              // m, its end inside the ground
  double turn = 1;              // +1 or -1: from the edge away from the structure
  double changed = 0;           // m behind the edge, to the end of all measures
  std::size_t on = 0, off = 0;  // sleepers that are judged on the structure and on plain track
};

// One for each block, in turn.
std::vector<Outline> outlines_of(const fem::GroundParameters& ground) {
  std::vector<Outline> blocks(ground.blocks.begin(), ground.blocks.end());
  double depth = 0;
  for (const fem::Layer& layer : ground.layers) depth += layer.thickness;
  for (Outline& top : blocks) {
    if (!top.stiff || top.z.high < -tiny) continue;
    const std::vector<Outline*> column = column_below(top, blocks);
    const auto reaches = [&](const Outline* each) { return -each->z.low >= deep * depth - tiny; };
    if (std::any_of(column.begin(), column.end(), reaches))
      for (Outline* each : column) each->structural = true;
  }
  return blocks;
}

std::optional<Parts> parts_of(const Model& model) {
  const fem::GroundParameters& ground = model.ground;
  std::vector<Outline> blocks;
  const std::vector<Outline> all = outlines_of(ground);
  for (std::size_t b = 0; b < all.size(); ++b)
    if (ground.blocks[b].present) blocks.push_back(all[b]);
  const auto inside = [&](double x) { return x > ground.x[0] + tiny && x < ground.x[1] - tiny; };
  // Structures along x; those that touch are one.
  std::vector<Extent> structures;
  std::sort(blocks.begin(), blocks.end(),
            [](const Outline& a, const Outline& b) { return a.x.low < b.x.low; });
  for (const Outline& block : blocks) {
    if (!block.structural || block.z.high < -tiny) continue;
    if (!structures.empty() && block.x.low <= structures.back().high + tiny)
      structures.back().add(block.x.high);
    else
      structures.push_back(block.x);
  }
  const auto found = std::find_if(structures.begin(), structures.end(), [&](const Extent& each) {
    return inside(each.low) || inside(each.high);
  });
  if (found == structures.end()) return {};
  Parts parts{.structure = *found};
  parts.turn = inside(found->high) ? 1 : -1;
  parts.edge = parts.turn > 0 ? found->high : found->low;
  for (const Outline& block : blocks)
    if (!block.structural)
      parts.changed = std::max({parts.changed, parts.turn * (block.x.low - parts.edge),
                                parts.turn * (block.x.high - parts.edge)});
  return parts;
}

void count_sleepers(const Model& model, Parts& parts) {
  const track::SleeperParameters& sleepers = model.sleepers;
  const auto count = static_cast<std::size_t>(sleepers.count);
  std::size_t ends = 0;
  for (const std::size_t each : {ends_at_walls, ends_on_springs})
    if (count > 2 * each && (each == ends_at_walls || model.has_train())) ends = each;
  for (std::size_t k = ends; k + ends < count; ++k) {
    const double x = sleepers.first + static_cast<double>(k) * sleepers.spacing;
    const double distance = parts.turn * (x - parts.edge);
    parts.on += distance <= -sleepers.spacing + tiny && x >= parts.structure.low - tiny &&
                x <= parts.structure.high + tiny;
    parts.off += distance >= parts.changed + behind * sleepers.spacing - tiny;
  }
}

}  // namespace

std::vector<bool> structural_blocks(const fem::GroundParameters& ground) {
  std::vector<bool> found;
  for (const Outline& block : outlines_of(ground)) found.push_back(block.structural);
  return found;
}

std::string words_of_comparison(const Model& model) {
  const fem::GroundParameters& ground = model.ground;
  if (!ground.present || ground.blocks.empty() || ground.x.size() != 2 || ground.layers.empty() ||
      model.sleepers.count < 1 || !model.has_stage(StageKind::passage))
    return "";
  std::optional<Parts> parts = parts_of(model);
  if (!parts)
    return fmt::format(
        "  transition: no block at the surface is a structure (at least {:g} GPa, from the surface "
        "over at least "
        "half of the depth of the ground, or role = \"structure\"): comparisons give no verdict",
        stiff_as_structure / 1e9);
  count_sleepers(model, *parts);
  const double plain =
      parts->edge + parts->turn * (parts->changed + behind * model.sleepers.spacing);
  return fmt::format(
      "  transition: structure up to x = {:g} m, plain track from x = {:g} m or later; comparisons "
      "judge {} of the sleepers on the structure and at most {} on plain track{}",
      parts->edge, plain, parts->on, parts->off,
      std::min(parts->on, parts->off) < few
          ? fmt::format(" (a verdict needs at least {} on each)", few)
          : "");
}

}  // namespace trackbed::model
