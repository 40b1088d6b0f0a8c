// The number of stones is estimated from volumes: a layer of expected height and porosity, cut by
// the profile and by the sleepers, loses the same fraction of its stones as of its volume.
//
// Cost: a sum over the width; `require_stones` has drawn the stones of the layers before.
#include "model/check/forecast.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "trackbed/bed/library.hpp"

namespace trackbed::model {

namespace {

// s of wall time of one sub-step on one core, per stone and per piece; only for an estimate. From
// runs of the decks in inputs/: single spheres, and stones of about 20 pebbles, in space and in a
// plane; for pieces with corners the middle of the runs of docs/scaling.md.
constexpr double time_per_stone = 75e-9, time_per_polyhedron = 330e-9;
constexpr double time_per_ball(Dimension dimension) {
  return dimension == Dimension::plane ? 5e-9 : 15e-9;
}

struct Cut {
  double crest = 0;           // m; 0: nothing is cut
  double sleepers_from = -1;  // m, their lower faces; below 0: no stones are removed for them
  double stone = 0;           // m, radius of the sphere (plane: disk) of a stone's mean volume
};

double radius_of(double volume, Dimension dimension) {
  return dimension == Dimension::plane ? std::sqrt(volume / std::numbers::pi)
                                       : std::cbrt(0.75 * volume / std::numbers::pi);
}

// The last cut of the deck determines what is left at the end.
Cut cut_of(const Model& model) {
  Cut cut;
  for (const Stage& stage : model.stages) {
    if (stage.profile > 0) cut.crest = stage.profile;
    if (stage.kind == StageKind::sleepers && stage.height > 0) cut.sleepers_from = stage.height;
  }
  return cut;
}

std::string sentence_of(const LayerForecast& layer, const Cut& cut, bool copies) {
  const std::string made = fmt::format(
      "  {}: {} stones are {}", layer.layer.empty() ? "layer of [bed]" : "layer " + layer.layer,
      layer.made, copies ? "copies of those of the cell" : "poured");
  const bool trims = cut.crest > 0, places = cut.sleepers_from >= 0;
  if (!trims && !places) return made;
  return fmt::format("{}; about {} of them remain after {}{}{}", made, layer.left,
                     trims ? "trimming to the profile" : "", trims && places ? " and " : "",
                     places ? "placing the sleepers" : "");
}

double overlap(double a, double b, double c, double d) {
  return std::max(0.0, std::min(b, d) - std::max(a, c));
}

// Fraction of the layer between z = `low` and `high` that the cut leaves, by the midpoint rule
// across the bed: exact to 1/strips of the width, since the outline consists of straight lines. The
// outline cuts by centres; a sleeper removes all stones that touch it, so it counts as larger by a
// stone's radius.
double fraction_left(const Model& model, const Cut& cut, double low, double high) {
  constexpr int strips = 2000;
  const bed::BedParameters& bed = model.bed;
  const track::SleeperParameters& s = model.sleepers;
  const bool plane = model.dimension == Dimension::plane;
  const double width = bed.y[1] - bed.y[0];
  const double covered = std::min(
      1.0, static_cast<double>(s.count) * (s.width + 2 * cut.stone) / (bed.x[1] - bed.x[0]));
  double left = 0;
  for (int k = 0; k < strips; ++k) {
    const double y = bed.y[0] + (k + 0.5) * width / strips;
    const double top = cut.crest > 0 ? std::clamp(bed.top_at(y, cut.crest), low, high) : high;
    double height = top - low;
    const bool below_sleeper = plane || std::abs(y - s.y) < s.length / 2 + cut.stone;
    if (cut.sleepers_from >= 0 && below_sleeper)
      height -= covered * overlap(low, top, cut.sleepers_from - cut.stone,
                                  cut.sleepers_from + s.height + cut.stone);
    left += height / strips;
  }
  return left / (high - low);
}

// s, for a stone in a sub-step.
double step_time(double balls, double polyhedra, Dimension dimension) {
  return time_per_stone + balls * time_per_ball(dimension) + polyhedra * time_per_polyhedron;
}

// The same for a stone of the layer.
double step_time(const par::Comm& comm, const bed::BedParameters& layer, Dimension dimension) {
  const std::vector<dem::Template> shapes = bed::templates(comm, layer, dimension);
  double balls = 0, polyhedra = 0;
  for (const dem::Template& shape : shapes)
    for (const dem::Piece& piece : shape.pieces)
      ++(piece.core.vertices.size() > 1 ? polyhedra : balls);
  const auto count = static_cast<double>(std::max<std::size_t>(1, shapes.size()));
  return step_time(balls / count, polyhedra / count, dimension);
}

// The same for the mean stone of a cell. Collective.
double step_time_of_copies(const World& world) {
  const dem::Totals totals = world.particles.totals();
  const double pieces = static_cast<double>(totals.pieces) /
                        static_cast<double>(std::max<std::int64_t>(1, totals.particles));
  const bool corners = world.particles.any_corners();
  return step_time(corners ? 0 : pieces, corners ? pieces : 0, world.model.dimension);
}

}  // namespace

std::vector<LayerForecast> forecast(const World& world, const StonesOfLayers& stones) {
  const Model& model = world.model;
  const par::Comm& comm = world.comm;
  std::vector<LayerForecast> layers;
  Cut cut = cut_of(model);
  const double area = (model.bed.x[1] - model.bed.x[0]) *
                      (model.dimension == Dimension::plane ? 1 : model.bed.y[1] - model.bed.y[0]);
  double low = 0;
  for (const Stage& stage : model.stages) {
    if (stage.kind != StageKind::fill) continue;
    const bed::BedParameters bed = model.bed.of_layer(stage.layer);
    LayerForecast layer{.layer = stage.layer};
    const bool copies = !model.bed.cell.empty();
    layer.made = copies ? world.particles.totals().particles : stones.at(stage.layer).count;
    const auto made = static_cast<double>(layer.made);
    cut.stone = radius_of(area * bed.height * (1 - bed.porosity) / made, model.dimension);
    layer.left = std::llround(fraction_left(model, cut, low, low + bed.height) * made);
    layer.step_time = copies ? step_time_of_copies(world) : step_time(comm, bed, model.dimension);
    layers.push_back(layer);
    low += bed.height;
  }
  return layers;
}

std::string table_of_times(Dimension dimension) {
  return fmt::format(
      "{:.0f} ns in a sub-step for each stone, {:.0f} ns for each ball and {:.0f} ns for each "
      "polyhedron of a stone",
      time_per_stone * 1e9, time_per_ball(dimension) * 1e9, time_per_polyhedron * 1e9);
}

std::vector<std::string> sentences_of(const Model& model,
                                      const std::vector<LayerForecast>& layers) {
  std::vector<std::string> lines;
  for (const LayerForecast& layer : layers)
    if (layers.size() > 1 || !layer.layer.empty() || layer.left != layer.made)
      lines.push_back(sentence_of(layer, cut_of(model), !model.bed.cell.empty()));
  return lines;
}

}  // namespace trackbed::model
