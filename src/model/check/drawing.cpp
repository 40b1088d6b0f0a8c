// The drawing of a deck's model before it runs, seen from the side, from its parameters alone.
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "model/check/comparison.hpp"
#include "model/check/picture.hpp"
#include "trackbed/model/checks.hpp"
#include "trackbed/track/rail.hpp"
#include "trackbed/track/vehicle_layout.hpp"

namespace trackbed::model {

namespace {

// m, of parts that have no size in the deck, or no height in a side view.
constexpr double spring_width = 0.26, spring_height = 0.3;
constexpr double body_floor = 1.0, body_top = 3.4, body_overhang = 1.5;
constexpr Paint ballast{.fill = "#8c8c8c", .line = "#555", .opacity = 0.45};
constexpr Paint block{.fill = "#a9c9a4", .line = "#4f7a4a"};
constexpr Paint structure{.fill = "#9aa0a6", .line = "#4d4d4d"};
constexpr Paint sleeper{.fill = "#5b4636", .line = "#5b4636"};
constexpr Paint on_springs{.fill = "white", .line = "#5b4636", .width = 1.2};
constexpr Paint thin{.line = "#333"}, rail{.line = "#222", .width = 4};
constexpr Paint wheel{.fill = "#444", .line = "black"}, body{.fill = "#dfe7ef", .line = "#2f4b66"};
constexpr Paint load{.line = "#c1121f", .width = 1.5};
constexpr Paint stone{.fill = "#b5a48f", .line = "#5b4636", .width = 0.6, .opacity = 0.6};
constexpr const char* layer_fill[] = {"#e8dcc0", "#d9c7a0", "#c8b184", "#b79b6c"};

std::string modulus(double pascal) {
  return pascal >= 1e9 ? fmt::format("{:g} GPa", pascal / 1e9)
                       : fmt::format("{:g} MPa", pascal / 1e6);
}

void draw_blocks(const fem::GroundParameters& ground, Picture& picture) {
  const std::vector<bool> structural = structural_blocks(ground);
  for (std::size_t k = 0; k < ground.blocks.size(); ++k) {
    const fem::Block& b = ground.blocks[k];
    if (!b.present) continue;
    std::vector<Point2> corners;
    Point2 middle{0, 0}, low{b.outline[0], b.outline[1]}, high = low;
    for (std::size_t c = 0; c + 1 < b.outline.size(); c += 2) {
      const Point2 corner{b.outline[c], b.outline[c + 1]};
      corners.push_back(corner);
      middle.x += corner.x, middle.z += corner.z;
      low = {std::min(low.x, corner.x), std::min(low.z, corner.z)};
      high = {std::max(high.x, corner.x), std::max(high.z, corner.z)};
    }
    const auto count = static_cast<double>(corners.size());
    picture.polygon(std::move(corners), structural[k] ? structure : block);
    picture.name({middle.x / count, middle.z / count}, {high.x - low.x, high.z - low.z},
                 fmt::format("{}, {}", b.name, modulus(b.solid.young)));
  }
}

void draw_ground(const Model& model, Picture& picture) {
  const fem::GroundParameters& ground = model.ground;
  if (!ground.present) return;
  if (!ground.mesh.empty()) {
    picture.note("The ground, from the mesh " + ground.mesh + ", is not drawn.");
    return;
  }
  double z = 0;
  for (std::size_t k = 0; k < ground.layers.size(); ++k) {
    const fem::Layer& layer = ground.layers[k];
    picture.rectangle({ground.x[0], z - layer.thickness}, {ground.x[1], z},
                      {.fill = layer_fill[k % std::size(layer_fill)], .line = "#888"});
    picture.name(
        {ground.x[1], z - layer.thickness / 2}, {ground.x[1] - ground.x[0], layer.thickness},
        fmt::format("{}, {} ", layer.name,
                    layer.young_file.empty() ? modulus(layer.solid.young) : "modulus from a file"),
        Anchor::end);
    z -= layer.thickness;
  }
  draw_blocks(ground, picture);
  if (!ground.sections.empty())
    picture.note("The ground is an embankment; the drawing shows its layers below the crest.");
}

// Layers of ballast as they are poured, walls at ends that are not periodic.
void draw_bed(const Model& model, Picture& picture) {
  const double from = model.bed.x[0], to = model.bed.x[1];
  double z = 0;
  const auto add = [&](const std::string& name, double height) {
    picture.rectangle({from, z}, {to, z + height}, ballast);
    picture.name({(from + to) / 2, z + height / 4}, {to - from, height},
                 fmt::format("{}, {:g} m", name.empty() ? model.bed.material : name, height));
    z += height;
  };
  for (const Stage& stage : model.stages)
    if (stage.kind == StageKind::fill) add(stage.layer, model.bed.of_layer(stage.layer).height);
  if (z == 0) add("", model.bed.height);  // poured in another run
  if (model.periodic_in("x")) return;
  for (const double x : {from, to})
    picture.line({{x, 0}, {x, 1.2 * z}}, {.line = "#222", .width = 3});
}

void draw_spring(double x, double from, double to, Picture& picture) {
  constexpr double aside[] = {0, 0, 0.06, -0.06, 0.06, -0.06, 0, 0};
  std::vector<Point2> points;
  for (std::size_t k = 0; k < std::size(aside); ++k)
    points.push_back(
        {x + aside[k], from + (to - from) * static_cast<double>(k) / (std::size(aside) - 1)});
  picture.line(std::move(points), thin);
  picture.line({{x - spring_width / 2, from}, {x + spring_width / 2, from}}, thin);
}

// Where a track is in the model. `count` sleepers, the first of them number `first`, lie on stones
// or on the ground, all others on springs.
struct TrackPlace {
  double origin;         // m, x of the model at the start of the track
  double underside;      // m, z of the lower faces of the sleepers
  double width, height;  // m, of a sleeper
  std::size_t first, count;
};

void draw_train(const Model& model, const TrackPlace& place, double top, Picture& picture) {
  const auto train = train_of(model.track);
  if (!train) return;
  // Over the sleepers on stones or ground, so that both are seen at one scale.
  const track::TrackParameters& line = model.track.line.track;
  const double start = place.origin + model.track.train.start;
  const bool moved = place.count > 0;
  const double front =
      moved ? place.origin + line.sleeper_x(place.first + (3 * place.count) / 4) : start;
  const double radius = model.track.wheel_rail.bodies.wheel_radius;
  double first = 0, last = 0;
  std::size_t axle = 0;
  std::vector<double> axles;
  for (const track::Train::Wheel& w : train->wheels())
    if (w.side == 0) axles.push_back(front - w.behind);
  // Beside a long train the rest would be small.
  const double furthest = moved ? place.origin : std::min(place.origin, front) - line.length / 2;
  std::size_t drawn = 0;
  for (const track::VehicleParameters& vehicle : train->vehicles()) {
    const std::size_t own = track::axles_of(vehicle).size();
    if (own == 0 || axle + own > axles.size() || axles[axle] < furthest) break;
    ++drawn;
    first = axles[axle], last = axles[axle + own - 1], axle += own;
    if (own > 1)
      picture.rectangle({last - body_overhang, top + body_floor},
                        {first + body_overhang, top + body_top}, body);
    picture.text({(first + last) / 2, top + (own > 1 ? body_top : 2 * radius)}, vehicle.name,
                 Anchor::middle, own > 1 ? 18 : -6);
  }
  for (std::size_t k = 0; k < axle; ++k) picture.circle({axles[k], top + radius}, radius, wheel);
  if (const std::size_t more = train->vehicles().size() - drawn; more > 0)
    picture.note(fmt::format("{} vehicle{} at the end of the train {} not drawn.", more,
                             more > 1 ? "s" : "", more > 1 ? "are" : "is"));
  picture.note(fmt::format(
      "{}, {:.5g} km/h towards the right.",
      moved ? fmt::format("The train is drawn over the {}; it starts with its first axle at "
                          "x = {:g} m",
                          model.kind == ModelKind::bed ? "bed" : "ground", start)
            : "Train at its start",
      3.6 * model.track.train.speed));
}

void draw_track(const Model& model, const TrackPlace& place, Picture& picture) {
  const track::TrackParameters& line = model.track.line.track;
  const double top = place.underside + place.height;
  const bool sleepers = line.support == track::Support::sleepers;
  const std::size_t count = sleepers ? model.track.sleepers() : 0;
  for (std::size_t k = 0; k < count; ++k) {
    const double x = place.origin + line.sleeper_x(k);
    const bool carried = k >= place.first && k < place.first + place.count;
    picture.rectangle({x - place.width / 2, place.underside}, {x + place.width / 2, top},
                      carried ? sleeper : on_springs);
    if (!carried) draw_spring(x, place.underside - spring_height, place.underside, picture);
  }
  const double level = (sleepers ? top : 0) + track::drawn_rail_height;
  picture.line({{place.origin, level}, {place.origin + line.length, level}}, rail);
  if (model.track.train.vehicles.empty()) return;
  draw_train(model, place, level, picture);
}

void draw_sleepers(const Model& model, Picture& picture) {
  double underside = model.bed.height;
  for (const Stage& stage : model.stages)
    if (stage.kind == StageKind::sleepers) underside = stage.height;
  const track::SleeperParameters& s = model.sleepers;
  if (model.has_train()) {
    const auto before = static_cast<std::size_t>(model.seat.before);
    draw_track(model,
               {s.first - model.track.line.track.sleeper_x(before), underside, s.width, s.height,
                before, static_cast<std::size_t>(s.count)},
               picture);
    return;
  }
  for (std::int64_t k = 0; k < s.count; ++k) {
    const double x = s.first + static_cast<double>(k) * s.spacing;
    picture.rectangle({x - s.width / 2, underside}, {x + s.width / 2, underside + s.height},
                      sleeper);
  }
}

void draw_pressures(const Model& model, Picture& picture) {
  constexpr int arrows = 6;
  constexpr double length = 0.5, head = 0.12;  // m
  for (const PressureParameters& p : model.pressures) {
    for (int k = 0; k <= arrows; ++k) {
      const double x = p.x[0] + (p.x[1] - p.x[0]) * k / arrows;
      picture.line({{x, length}, {x, 0}, {x - head / 2, head}}, load);
      picture.line({{x, 0}, {x + head / 2, head}}, load);
    }
    picture.text({(p.x[0] + p.x[1]) / 2, length},
                 fmt::format("{}, {:g} kPa", p.name, p.pressure / 1e3), Anchor::middle, -6);
  }
}

// The faces of a piece, seen from the side; of a ball its outline.
void draw_piece(const geom::Piece& piece, Picture& picture) {
  for (const geom::Face& face : piece.core.faces) {
    std::vector<Point2> corners;
    for (const int v : face.vertices) {
      const Vec3& p = piece.core.vertices[static_cast<std::size_t>(v)];
      corners.push_back({p.x(), p.z()});
    }
    picture.polygon(std::move(corners), stone);
  }
  if (piece.core.faces.empty())
    for (const Vec3& p : piece.core.vertices) picture.circle({p.x(), p.z()}, piece.radius, stone);
}

void draw_placed(const Model& model, const std::vector<bed::PlacedShape>& shapes,
                 Picture& picture) {
  const PlacedParameters& placed = model.placed;
  const bed::PlacedSurfaces surfaces(placed.plates, placed.boxes, model.physics, model.dimension,
                                     model.thickness);
  for (const Surface& surface : surfaces.surfaces())
    for (const auto& triangle : surface.triangles) {
      std::vector<Point2> corners;
      for (const std::int32_t node : triangle) {
        const Vec3& p = surface.position[static_cast<std::size_t>(node)];
        corners.push_back({p.x(), p.z()});
      }
      corners.push_back(corners.front());
      picture.line(std::move(corners), {.line = "#222", .width = 2});
    }
  for (std::size_t i = 0; i < placed.stones.size() && i < shapes.size(); ++i) {
    for (const geom::Piece& piece : bed::pieces_in_space(shapes[i], placed.stones[i]))
      draw_piece(piece, picture);
    picture.text({placed.stones[i].position[0], placed.stones[i].position[2]},
                 placed.stones[i].name, Anchor::middle, 4);
  }
}

}  // namespace

std::string drawing_of(const Model& model, const std::vector<bed::PlacedShape>& shapes,
                       const std::string& name) {
  Picture picture(fmt::format("{} ({})", model.title.empty() ? name : model.title,
                              model.dimension == Dimension::plane
                                  ? fmt::format("plane model, {:g} m thick", model.thickness)
                                  : std::string("model in space, seen from the side")));
  if (model.is_placed()) {
    draw_placed(model, shapes, picture);
    return picture.svg();
  }
  if (model.kind != ModelKind::track) draw_ground(model, picture);
  if (model.has_bed()) {
    draw_bed(model, picture);
    if (model.uses_sleepers()) draw_sleepers(model, picture);
  }
  if (!model.has_stages()) {
    const bool ground = model.kind == ModelKind::track_on_ground;
    const observe::TrackShape shape = shape_of_track(model);
    draw_track(model,
               {shape.origin, spring_height, shape.width, shape.height,
                static_cast<std::size_t>(model.footing.before),
                ground ? static_cast<std::size_t>(model.footing.count) : 0},
               picture);
    if (ground) picture.note("Springs of the ballast between sleepers and ground are not drawn.");
  }
  draw_pressures(model, picture);
  return picture.svg();
}

}  // namespace trackbed::model
