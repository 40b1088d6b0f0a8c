// Stones are made from the deck alone, so that a run is refused before it writes anything.
#include "model/scene/layer_stones.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>

#include "model/rules/limits.hpp"
#include "model/scene/cell.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/dem/stiffness.hpp"

namespace trackbed::model {

namespace {

// A sentence about the file of shapes gets the position in the deck that names it.
bed::Stones stones_of(const par::Comm& comm, const Model& model, const std::string& layer,
                      const input::Deck& deck) {
  const bed::BedParameters bed = model.bed.of_layer(layer);
  try {
    return bed::stones_of(comm, bed, model.domain());
  } catch (const InputError& error) {  // equal on all ranks
    const std::string words = error.what(), start = bed.library + ": ";
    if (bed.library.empty() || !words.starts_with(start)) throw InputError({deck.located(words)});
    const std::string key =
        layer.empty() ? "bed.library" : fmt::format("bed.layer.{}.library", layer);
    throw InputError(
        {fmt::format("{} = \"{}\" {}", deck.where(key), bed.library, words.substr(start.size()))});
  }
}

// Layers that stages fill, each once; cribs are filled with the uppermost one.
std::set<std::string> layers_made(const Model& model) {
  std::set<std::string> layers;
  for (const Stage& stage : model.stages) {
    const bool fills =
        stage.kind == StageKind::fill && model.start.empty() && model.bed.cell.empty();
    if (fills || stage.kind == StageKind::cribs) layers.insert(stage.layer);
  }
  return layers;
}

// The neighbour search needs three cells along a periodic side. The chosen skin is known only with
// the stones, so that a length slightly above this limit may still be refused later.
void require_length(const Model& model, const std::string& layer, double largest_bound,
                    const input::Deck& deck) {
  const dem::Domain domain = model.domain();
  const double least = 3 * (2 * largest_bound + model.dem.skin);
  std::vector<std::string> problems;
  for (const int axis : {0, 1}) {
    const double length = domain.high[axis] - domain.low[axis];
    if (!domain.periodic[static_cast<std::size_t>(axis)] || length >= least) continue;
    problems.push_back(fmt::format(
        "{}: the length of the bed along a periodic axis is {:.4g} m and must be at least {:.4g} "
        "m, 3 times the sum of dem.skin and the diameter of the sphere around its largest stone{}; "
        "make the bed longer, or dem.skin or the stones smaller",
        deck.where(axis == 0 ? "bed.x" : "bed.y"), length, least,
        layer.empty() ? "" : fmt::format(" of layer {}", layer)));
  }
  if (!problems.empty()) throw InputError(problems);
}

// Loose stones need several times the volume of the compacted bed, and a layer falls from above the
// layers below it. Cribs are not checked: their height is known only from the sleepers.
void require_fill_height(const Model& model, const StonesOfLayers& layers,
                         const input::Deck& deck) {
  double below = 0;
  for (const Stage& stage : model.stages) {
    if (stage.kind != StageKind::fill || !model.start.empty() || !model.bed.cell.empty()) continue;
    const double top = below + layers.at(stage.layer).top;
    const double high = model.domain().high.z();
    const std::string section = model.bed.of_layer(stage.layer).section;
    if (stage.growth == 0 && top > high)  // growing stones begin small
      throw InputError({fmt::format(
          "{}: the loose stones would reach {:.3g} m, above the limit of {:.3g} m (1 m plus ten "
          "times the height of all layers); make the bed wider, let the stones grow in place "
          "(stage.growth above 0), or make them rounder (a larger I/L: {}.elongation for pebbles, "
          "{}.polyhedron.elongation for other generated stones)",
          deck.where(section + ".height"), top, high, section, section)});
    below += model.bed.of_layer(stage.layer).height;
  }
}

}  // namespace

// Existing stones (a start from a checkpoint) do not follow from the deck; their limit is checked
// in `choose_steps`.
StonesOfLayers require_stones(const par::Comm& comm, const Model& model, const input::Deck& deck) {
  const bool fills = model.start.empty() && model.has_stage(StageKind::fill);
  if (fills && !model.bed.cell.empty()) require_cell(comm, model, deck);
  StonesOfLayers layers;
  for (const std::string& layer : layers_made(model))
    layers[layer] = stones_of(comm, model, layer, deck);
  require_fill_height(model, layers, deck);
  for (const auto& [layer, stones] : layers) {
    require_length(model, layer, stones.largest_bound, deck);
    if (!model.start.empty() || stones.count < 1) continue;
    const StonesStep step = step_of(model, {{layer, stones}});
    require_stable(model, deck, step.longest, step.limit);
  }
  return layers;
}

// Sieving does not measure the length of a stone, which passes lengthwise. EN 13450 counts stones
// longer than three times their thickness; stones of the default proportions are 1.5 sieves long,
// at most 1.9.
std::vector<std::string> warnings_of(const Model& model, const StonesOfLayers& layers) {
  constexpr double surprising = 2.5;
  std::vector<std::string> all;
  for (const auto& [name, stones] : layers) {
    const double sieve = sieve_high(model.bed.of_layer(name));
    if (!(stones.longest > surprising * sieve)) continue;
    all.push_back(fmt::format(
        "{}: the longest stone is {:.3g} mm long, {:.2g} times the largest sieve of {:.3g} mm, "
        "since its shape is elongated or flat (`trackbed shapes` prints S, I and L)",
        name.empty() ? "bed" : fmt::format("bed.layer.{}", name), 1e3 * stones.longest,
        stones.longest / sieve, 1e3 * sieve));
  }
  return all;
}

StonesStep step_of(const Model& model, const StonesOfLayers& layers, double stiffness) {
  const double thickness = model.dimension == Dimension::plane ? model.thickness : 1;
  double lightest = std::numeric_limits<double>::infinity(), largest = 0;
  for (const auto& [layer, stones] : layers) {
    const double density = density_of_stones(model, model.bed.of_layer(layer));
    lightest = std::min(lightest, density * stones.smallest_volume * thickness);
    largest = std::max(largest, stones.largest_bound);
  }
  const dem::BreakageParameters& breakage = model.breakage;
  if (const int number = model.material(breakage.material); breakage.any() && number >= 0)
    lightest = std::min(
        lightest,
        least_fragment(breakage, model.physics.materials[static_cast<std::size_t>(number)]));
  StonesStep step;
  step.longest = dem::stable_step(dem::with_stiffness(model.physics, stiffness), model.dem,
                                  lightest, largest, &step.limit);
  return step;
}

}  // namespace trackbed::model
