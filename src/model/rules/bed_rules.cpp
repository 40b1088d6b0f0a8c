// Rules for what a bed is built from: its layers, and the outline to which stages cut it.
//
// An impossible outline is an error. An outline that is cut off by a wall gives a warning: a bed
// between the walls of a bridge has no complete slope, but in most decks complete slopes are meant.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "model/rules/rules.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::model {

namespace {

std::vector<std::string> names_of(const std::vector<bed::NamedLayer>& layers) {
  std::vector<std::string> names;
  for (const bed::NamedLayer& layer : layers) names.push_back(layer.name);
  return names;
}

// Remedy for an unknown name: the names that exist.
std::string instead_of(const std::string& name, const std::vector<std::string>& names) {
  if (names.empty()) return "the deck has none";
  const std::string near = input::nearest(name, names);
  return near.empty() ? fmt::format("the deck has {}", fmt::join(names, ", "))
                      : fmt::format("did you mean {}?", near);
}

// Why stones of this kind cannot be made in the model; empty if they can.
std::string misfit(const bed::LayerParameters& layer, Dimension dimension) {
  using enum bed::StoneKind;
  if (dimension == Dimension::space)
    return layer.stone == pebbles ? "gives plane stones, which need dimension = \"plane\"" : "";
  const bool plane = layer.stone == pebbles || layer.stone == disk ||
                     (layer.stone == clump && !layer.clump.empty());
  return plane ? ""
               : "gives three-dimensional stones: a plane model allows disk, pebbles, and clump "
                 "with the spheres given in `clump`";
}

}  // namespace

// After a start from a checkpoint a layer may have been poured already, so that no warning is given
// for a layer that no stage pours.
void declare_layers(const Model& model, input::Section& s) {
  const std::vector<std::string> names = names_of(model.bed.layers);
  const auto again = std::find_if(names.begin(), names.end(), [&](const std::string& name) {
    return std::count(names.begin(), names.end(), name) > 1;
  });
  s.rule("bed.layer", again == names.end(),
         fmt::format("layers must have different names; several have the name \"{}\"",
                     again == names.end() ? "" : *again),
         {.reads = {"bed.layer"}});
  std::set<std::string> poured;
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const std::string& layer = model.stages[i].layer;
    if (model.stages[i].kind == StageKind::fill) poured.insert(layer);
    const std::string key = fmt::format("stage[{}].layer", i);
    s.rule(key, layer.empty() || std::find(names.begin(), names.end(), layer) != names.end(),
           fmt::format("there is no [[bed.layer]] \"{}\"; {}", layer, instead_of(layer, names)),
           {.reads = {key, "bed.layer"}});
  }
  s.rule("bed.seed",
         model.bed.cell.empty() || model.has_stage(StageKind::cribs) ||
             model.bed.seed == bed::BedParameters{}.seed,
         "has no effect with bed.cell, whose stones are copied: give it to the deck of the cell",
         {.severity = input::Severity::warning, .reads = {"bed.cell", "bed.seed", "stage"}});
  // Layers that no stage pours are not checked.
  const auto fits = [&](const std::string& key, const bed::LayerParameters& layer) {
    const std::string why = misfit(layer, model.dimension);
    s.rule(key + ".stone", why.empty(), why, {.reads = {"dimension", key, "stage"}});
  };
  if (poured.contains("") || model.has_stage(StageKind::cribs)) fits("bed", model.bed);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (poured.contains(names[i])) fits(fmt::format("bed.layer[{}]", i), model.bed.layers[i]);
  for (std::size_t i = 0; i < names.size(); ++i)
    s.rule(fmt::format("bed.layer[{}].name", i), !model.start.empty() || poured.contains(names[i]),
           "is poured by no stage of kind fill",
           {.severity = input::Severity::warning, .reads = {"stage", "bed.layer"}});
}

// Values of a bed below sleepers that are rarely meant: they leave out what carries a track.
void declare_ballast(const Model& model, input::Section& s) {
  if (!model.has_bed() || !model.uses_sleepers()) return;
  const input::About about{.severity = input::Severity::warning,
                           .reads = {"contact", "material", "bed", "sleepers", "dem", "stage"}};
  const std::string& stones = model.bed.material;
  constexpr const char* without_friction = "stones without friction do not carry sleepers";
  bool used = false;  // friction of contact laws, which stages may replace
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const Stage& stage = model.stages[i];
    const bool loads = stage.kind == StageKind::load || stage.kind == StageKind::passage;
    used = used || (loads && stage.friction < 0);
    s.rule(fmt::format("stage[{}].friction", i), !loads || stage.friction != 0, without_friction,
           about);
  }
  for (std::size_t i = 0; i < model.physics.laws.size(); ++i) {
    const dem::ContactLaw& law = model.physics.laws[i];
    const auto between = [&](const std::string& one, const std::string& other) {
      return one == stones && (other == stones || other == model.sleepers.material);
    };
    const bool carries = between(law.first, law.second) || between(law.second, law.first);
    s.rule(fmt::format("contact[{}].friction", i), law.friction > 0 || !carries || !used,
           without_friction, about);
  }
  constexpr double rock = 1900;  // kg/m3, below that of any rock used as ballast
  const int material = model.material(stones);
  if (material >= 0)
    s.rule(
        fmt::format("material[{}].density", material),
        model.physics.materials[static_cast<std::size_t>(material)].density >= rock,
        fmt::format("is below {:g} kg/m3; rock has 2400 to 3200 kg/m3: is it the bulk density of "
                    "the ballast?",
                    rock),
        about);
  constexpr double low = 9, high = 10.5;  // m/s2
  s.rule("dem.gravity", model.dem.gravity >= low && model.dem.gravity <= high,
         fmt::format("is not that of the earth, {:g} m/s2: stones and sleepers have another weight",
                     gravity),
         about);
  const auto& free = model.sleepers.free;
  s.rule("sleepers.free",
         model.sleepers.model == track::SleeperBody::solid ||
             std::find(free.begin(), free.end(), "z") != free.end(),
         "does not contain z: the sleepers do not move vertically, and their loads do not reach "
         "the bed",
         about);
}

// A complete slope needs slope * height of horizontal run beside the crest; with less, it ends at a
// wall of the bed.
void declare_profile(const Model& model, input::Section& s) {
  const auto& crest = model.bed.crest;
  const auto& y = model.bed.y;
  s.rule("bed.crest", crest.empty() || model.dimension == Dimension::space,
         "has no meaning in a plane model, which has no width; leave it out",
         {.reads = {"dimension", "bed.crest"}});
  if (crest.size() != 2 || y.size() != 2) return;
  double top = 0;
  for (const Stage& stage : model.stages) top = std::max(top, stage.profile);
  s.rule("bed.crest", top > 0 || !model.start.empty(),
         "has no effect: no stage has a profile; give a profile to a stage after the compaction of "
         "the bed",
         {.severity = input::Severity::warning, .reads = {"stage", "bed"}});
  // m, height at which the slope ends at a wall; 0 at the crest itself, which has no slope.
  const auto held = [&](double run) { return run > 0 ? top - run / model.bed.slope : 0; };
  for (const double at : {held(crest[0] - y[0]), held(y[1] - crest[1])})
    s.rule("bed.crest", at <= 1e-9,
           fmt::format("the slope of {:g} below the crest (height {:g} m) ends at a side wall of "
                       "the bed, {:.3g} m above z = 0; make bed.y wider or the crest narrower",
                       model.bed.slope, top, at),
           {.severity = input::Severity::warning, .reads = {"stage", "bed"}});
}

}  // namespace trackbed::model
