// Rules of what a bed is built from: its layers and the outline that stages cut.
//
// An outline that cannot be is an error. One that a wall cuts off is a warning: a bed between the
// walls of a bridge has no slope to its foot, but who draws slopes mostly wants all of them.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "app/rules.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::app {

namespace {

std::vector<std::string> names_of(const std::vector<bed::NamedLayer>& layers) {
  std::vector<std::string> names;
  for (const bed::NamedLayer& layer : layers) names.push_back(layer.name);
  return names;
}

// What to write instead of a name that is none.
std::string instead_of(const std::string& name, const std::vector<std::string>& names) {
  if (names.empty()) return "the deck has none";
  const std::string near = input::nearest(name, names);
  return near.empty() ? fmt::format("there is {}", fmt::join(names, ", "))
                      : fmt::format("did you mean {}?", near);
}

// Empty if stones of this kind can be made in the model.
std::string misfit(const bed::LayerParameters& layer, Dimension dimension) {
  using enum bed::StoneKind;
  if (dimension == Dimension::space)
    return layer.stone == pebbles ? "makes plane stones: the model must be a plane one" : "";
  const bool plane = layer.stone == pebbles || layer.stone == disk ||
                     (layer.stone == clump && !layer.clump.empty());
  return plane ? ""
               : "makes stones in space: a plane model takes disk, pebbles, or clump with the "
                 "spheres given in `clump`";
}

}  // namespace

// A start from a checkpoint may have poured a layer already: that none pours it is then no news.
void declare_layers(const Model& model, input::Section& s) {
  const std::vector<std::string> names = names_of(model.bed.layers);
  s.rule("bed.layer", std::set(names.begin(), names.end()).size() == names.size(),
         "layers need different names", {.reads = {"bed.layer"}});
  std::set<std::string> poured;
  for (std::size_t i = 0; i < model.stages.size(); ++i) {
    const std::string& layer = model.stages[i].layer;
    if (model.stages[i].kind == StageKind::fill) poured.insert(layer);
    const std::string key = fmt::format("stage[{}].layer", i);
    s.rule(key, layer.empty() || std::find(names.begin(), names.end(), layer) != names.end(),
           fmt::format("there is no [[bed.layer]] \"{}\"; {}", layer, instead_of(layer, names)),
           {.reads = {key, "bed.layer"}});
  }
  // Layers that no stage makes may be anything.
  const auto fits = [&](const std::string& key, const bed::LayerParameters& layer) {
    const std::string why = misfit(layer, model.dimension);
    s.rule(key + ".stone", why.empty(), why, {.reads = {"dimension", key, "stage"}});
  };
  if (poured.contains("") || model.has_stage(StageKind::cribs)) fits("bed", model.bed);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (poured.contains(names[i])) fits(fmt::format("bed.layer[{}]", i), model.bed.layers[i]);
  for (std::size_t i = 0; i < names.size(); ++i)
    s.rule(fmt::format("bed.layer[{}].name", i), !model.start.empty() || poured.contains(names[i]),
           "no stage of kind fill pours it",
           {.weight = input::Weight::warning, .reads = {"stage", "bed.layer"}});
}

// A slope needs slope * height of run beside the crest; with less, a wall of the bed holds it.
void declare_profile(const Model& model, input::Section& s) {
  const auto& crest = model.bed.crest;
  const auto& y = model.bed.y;
  s.rule("bed.crest", crest.empty() || model.dimension == Dimension::space,
         "a plane model has no width that a crest could end in; leave it out",
         {.reads = {"dimension", "bed.crest"}});
  if (crest.size() != 2 || y.size() != 2) return;
  double top = 0;
  for (const Stage& stage : model.stages) top = std::max(top, stage.profile);
  s.rule("bed.crest", top > 0 || !model.start.empty(),
         "no stage has a profile, so nothing is cut to it: give one to a stage after the bed is "
         "pressed",
         {.weight = input::Weight::warning, .reads = {"stage", "bed"}});
  // m, height at which a wall stands in the slope; at the crest itself there is no slope.
  const auto held = [&](double run) { return run > 0 ? top - run / model.bed.slope : 0; };
  for (const double at : {held(crest[0] - y[0]), held(y[1] - crest[1])})
    s.rule("bed.crest", at <= 1e-9,
           fmt::format("a slope of {:g} from the crest at {:g} m meets a side of the bed {:.3g} m "
                       "above its foot: the side wall holds it there; make bed.y wider or the "
                       "crest narrower",
                       model.bed.slope, top, at),
           {.weight = input::Weight::warning, .reads = {"stage", "bed"}});
}

}  // namespace trackbed::app
