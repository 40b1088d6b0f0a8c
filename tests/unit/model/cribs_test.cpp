// The space between sleepers, and the stones that fill it.
#include "model/stages/cribs.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>
#include <span>

#include "model/check/estimate.hpp"
#include "trackbed/geom/stone.hpp"

namespace trackbed::model::cribs_test {
namespace {

Model model(Dimension dimension) {
  Model m;
  m.dimension = dimension;
  m.physics.materials.push_back({.name = "ballast"});
  m.physics.materials.push_back({.name = "sleeper"});
  for (const char* other : {"ballast", "sleeper"})
    m.physics.laws.push_back({.first = "ballast", .second = other});
  m.bed.stone = bed::StoneKind::disk;
  m.bed.x = {0, 2};
  m.bed.y = {-1, 1};
  m.bed.height = 0.2;
  m.sleepers.count = 3;
  m.sleepers.first = 0.4;
  m.ground.present = false;
  m.stages.push_back({.name = "sleepers", .kind = StageKind::sleepers});
  return m;
}

StonesOfLayers stones_of(const World& scene) {
  StonesOfLayers stones;
  for (const Stage& stage : scene.model.stages)
    if (stage.kind == StageKind::fill)
      stones[stage.layer] =
          bed::stones_of(scene.comm, scene.model.bed.of_layer(stage.layer), scene.model.domain());
  return stones;
}

double volume(const std::vector<bed::Box>& boxes, bool plane) {
  double sum = 0;
  for (const bed::Box& box : boxes) {
    const Vec3 size = box.high - box.low;
    sum += size.x() * (plane ? 1 : size.y()) * size.z();
  }
  return sum;
}

TEST(Cribs, AreTheSpaceBesideTheSleepers) {
  const par::Comm world = par::Comm::world();
  for (const Dimension dimension : {Dimension::plane, Dimension::space}) {
    const Model deck = model(dimension);
    World scene(world, deck);
    scene.sleepers->place(0.3);
    const bool plane = dimension == Dimension::plane;
    const auto boxes = cribs(scene, 0.5);
    EXPECT_EQ(boxes.size(), plane ? 4u : 10u);
    const auto& s = deck.sleepers;
    const double rest = plane ? 2 - 3 * s.width : 2 * 2 - 3 * s.width * s.length;
    EXPECT_NEAR(volume(boxes, plane), 0.2 * rest, 1e-12);
    for (const bed::Box& box : boxes) {
      const Vec3 middle = (box.low + box.high) / 2;
      EXPECT_FALSE(scene.sleepers->overlaps(Vec3(middle.x(), plane ? 0 : middle.y(), 0.4), 1e-6));
    }
  }
}

TEST(Cribs, AreFilledWithNewStonesWithoutContacts) {
  const par::Comm world = par::Comm::world();
  const Model deck = model(Dimension::plane);
  World scene(world, deck);
  bed::fill(scene.particles, world, deck.bed, 0);
  const std::int64_t before = scene.particles.totals().particles;
  const double foot = scene.top_of_stones();
  scene.sleepers->place(foot);
  bed::fill_boxes(scene.particles, world, deck.bed, 0, cribs(scene, foot + 0.2), foot);
  std::vector<Id> ids;
  for (std::size_t i = 0; i < scene.particles.size(); ++i) {
    const dem::ParticleView stone = scene.particles[i];
    ids.push_back(stone.id);
    if (stone.id < before) continue;
    scene.particles.pieces(i, [&](const Vec3& centre, double radius) {
      EXPECT_GT(centre.z() - radius, foot);
      EXPECT_FALSE(scene.sleepers->overlaps(centre, radius));
    });
  }
  ids = world.all_gather(std::span<const Id>(ids));
  const std::set<Id> different(ids.begin(), ids.end());
  EXPECT_EQ(different.size(), ids.size());
  EXPECT_EQ(*different.rbegin(), static_cast<Id>(ids.size()) - 1);
  EXPECT_GT(static_cast<std::int64_t>(ids.size()), before + 20);
  EXPECT_EQ(scene.particles.totals().contacts, 0);

  const par::Comm self = par::Comm::self();
  World alone(self, deck);
  bed::fill(alone.particles, self, deck.bed, 0);
  alone.sleepers->place(foot);
  bed::fill_boxes(alone.particles, self, deck.bed, 0, cribs(alone, foot + 0.2), foot);
  EXPECT_EQ(scene.particles.state_hash(), alone.particles.state_hash());
}

// A flat slab, much wider than high: its bounding sphere is 0.33 m higher.
TEST(Stones, AreAsHighAsTheirHighestPoint) {
  const par::Comm world = par::Comm::world();
  World scene(world, model(Dimension::space));
  std::vector<Vec3> points;
  for (int k = 0; k < 8; ++k)
    points.emplace_back((k & 1) - 0.5, (k >> 1 & 1) - 0.5, 0.1 * ((k >> 2 & 1) - 0.5));
  const double rounding = 0.02, z = 0.3, scale = 0.5;
  const int slab =
      scene.particles.add_template(geom::template_of({{geom::convex_hull(points), rounding}}));
  dem::NewParticle stone{.shape = slab, .scale = scale, .position = Vec3(1, 0, z)};
  const auto mine = [&] { return std::span(&stone, world.root() ? 1 : 0); };
  scene.particles.add(mine());
  EXPECT_NEAR(scene.top_of_stones(), z + scale * (0.05 + rounding), 1e-12);
  // Another one on its edge.
  stone.id = 1, stone.position.z() = 1;
  stone.attitude = Eigen::AngleAxisd(std::numbers::pi / 4, Vec3::UnitY());
  scene.particles.add(mine());
  EXPECT_NEAR(scene.top_of_stones(), 1 + scale * (0.55 / std::sqrt(2.0) + rounding), 1e-12);
}

TEST(Cribs, AreCutAtTheirTop) {
  const par::Comm world = par::Comm::world();
  const Model deck = model(Dimension::plane);
  World scene(world, deck);
  bed::fill(scene.particles, world, deck.bed, 0);
  const std::int64_t before = scene.particles.totals().particles;
  cut_to_profile(scene, 0.2);
  for (std::size_t i = 0; i < scene.particles.size(); ++i)
    EXPECT_LE(scene.particles[i].position.z(), 0.2);
  const std::int64_t after = scene.particles.totals().particles;
  EXPECT_GT(after, 0);
  EXPECT_LT(after, before);
}

// Both slopes and the crest: stones outside are removed, all others remain.
TEST(Bed, IsCutToItsOutline) {
  const par::Comm world = par::Comm::world();
  Model deck = model(Dimension::space);
  deck.bed.crest = {-0.4, 0.7}, deck.bed.slope = 2;
  World scene(world, deck);
  bed::fill(scene.particles, world, deck.bed, 0);
  const auto inside = [&](const Vec3& at) {
    const double beside = std::max({0.0, -0.4 - at.y(), at.y() - 0.7});
    return at.z() <= 0.5 - beside / 2;
  };
  std::int64_t expected = 0;
  for (std::size_t i = 0; i < scene.particles.size(); ++i)
    expected += inside(scene.particles[i].position) ? 1 : 0;
  cut_to_profile(scene, 0.5);
  for (std::size_t i = 0; i < scene.particles.size(); ++i)
    EXPECT_TRUE(inside(scene.particles[i].position));
  EXPECT_EQ(scene.particles.totals().particles, world.sum(expected));
}

// A layer on the previous one: ids continue and are unique.
TEST(Layers, AreStacked) {
  const par::Comm world = par::Comm::world();
  Model deck = model(Dimension::space);
  deck.physics.laws.push_back({.first = "sleeper", .second = "sleeper"});
  bed::NamedLayer sand;
  sand.name = "sand", sand.stone = bed::StoneKind::disk, sand.material = "sleeper";
  sand.sieve = {30, 40}, sand.passing = {0, 100}, sand.height = 0.1;
  deck.bed.layers = {sand};
  deck.stages = {{.name = "sand", .kind = StageKind::fill, .layer = "sand", .duration = 1},
                 {.name = "stones", .kind = StageKind::fill, .duration = 1}};
  World scene(world, deck);
  StageActions actions(scene, deck);
  actions.begin(deck.stages[0]);
  const std::int64_t first = scene.particles.totals().particles;
  const double top = scene.top_of_stones();
  const StonesOfLayers stones = stones_of(scene);
  const double step = step_of(scene).longest;
  EXPECT_NEAR(step_of(deck, {*stones.find("sand")}).longest, step, 1e-12 * step);
  actions.begin(deck.stages[1]);
  std::vector<Id> ids;
  for (std::size_t i = 0; i < scene.particles.size(); ++i) {
    const dem::ParticleView stone = scene.particles[i];
    EXPECT_EQ(stone.material, stone.id < first ? 1 : 0);
    EXPECT_EQ(stone.position.z() < top, stone.id < first);
    ids.push_back(stone.id);
  }
  ids = world.all_gather(std::span<const Id>(ids));
  // The finer of both layers limits the steps from here on, as predicted before filling.
  EXPECT_LT(step_of(scene).longest, 0.9 * step);
  EXPECT_NEAR(step_of(deck, stones).longest, step_of(scene).longest, 1e-12 * step);
  const std::vector<LayerForecast> expected = forecast(scene, stones);
  EXPECT_EQ(std::set<Id>(ids.begin(), ids.end()).size(), ids.size());
  EXPECT_EQ(expected.at(0).made, first);
  EXPECT_EQ(expected.at(1).made, static_cast<std::int64_t>(ids.size()) - first);
  EXPECT_EQ(expected.at(1).left, expected.at(1).made);
}

// A bed of height h with slopes of 1: the triangles beside the crest are removed.
TEST(Forecast, CountsTheStonesThatRemain) {
  const par::Comm world = par::Comm::world();
  Model deck = model(Dimension::space);  // 2 m wide, 0.2 m high
  deck.bed.crest = {-1, 0.9}, deck.bed.slope = 0.5;
  deck.stages = {{.name = "fill", .kind = StageKind::fill, .duration = 1},
                 {.name = "cut", .kind = StageKind::settle, .duration = 1, .profile = 0.2}};
  const World scene(world, deck);
  const LayerForecast cut = forecast(scene, stones_of(scene)).at(0);
  const double removed =
      0.1 * 0.2 / 2 / (2 * 0.2);  // slope 0.5: 0.1 m of run over the whole height
  EXPECT_NEAR(static_cast<double>(cut.left), (1 - removed) * static_cast<double>(cut.made),
              1 + 1e-3 * static_cast<double>(cut.made));
  deck.stages.push_back({.name = "sleepers", .kind = StageKind::sleepers, .height = 0.1});
  const track::SleeperParameters& s = deck.sleepers;
  // Stones that touch a sleeper are removed: its box is larger by the mean stone's radius, up to
  // the top.
  const double stone = 2 * 2 * 0.2 * (1 - deck.bed.porosity) / static_cast<double>(cut.made);
  const double r = std::cbrt(0.75 * stone / std::numbers::pi);
  const double excavated = 3 * (s.width + 2 * r) * (s.length + 2 * r) * (0.1 + r) / (2 * 2 * 0.2);
  EXPECT_NEAR(static_cast<double>(forecast(scene, stones_of(scene)).at(0).left),
              (1 - removed - excavated) * static_cast<double>(cut.made),
              1 + 2e-3 * static_cast<double>(cut.made));
}

}  // namespace
}  // namespace trackbed::model::cribs_test
