// Exact cases of moving walls: a brick dragged by the floor, a brick without support by walls.
#include "model/stages/shear.hpp"

#include <gtest/gtest.h>

#include "support/stones.hpp"

namespace trackbed::model::shear_test {
namespace {

constexpr double half = 0.02, mu = 0.5, density = 2650;  // m, -, kg/m^3

// A box of 0.2 m on a floor; the upper walls are frictionless, so that only the floor carries the
// weight.
Model model() {
  Model m;
  m.dimension = Dimension::space;
  m.wall_material = "steel";
  for (const char* name : {"ballast", "steel", "oil"})
    m.physics.materials.push_back({.name = name});
  m.physics.materials[0].density = density;
  for (const char* other : {"ballast", "steel", "oil"}) {
    dem::ContactLaw law{.first = "ballast", .second = other};
    law.k_n = law.k_s = 1e6;
    law.friction = std::string(other) == "oil" ? 0 : mu;
    law.zeta_n = law.zeta_s = 0.5;
    m.physics.laws.push_back(law);
  }
  m.bed.x = {0, 0.2};
  m.bed.y = {0, 0.2};
  m.bed.split = 0.01, m.bed.beside = 0.05;
  m.ground.present = false;
  m.stages.push_back({.name = "shear", .kind = StageKind::shear, .duration = 0.2});
  m.stages.back().displacement = 0.02;
  return m;
}

// One brick at rest on the floor, at a distance `beside`, m, from the right wall.
struct Scene {
  Scene(const par::Comm& comm, const Model& deck, double beside) : world(comm, deck) {
    const int shape = world.particles.add_template(test::brick({half, half, half}, 0.002));
    const double weight = density * 8 * half * half * half * 9.81;
    dem::NewParticle brick;
    brick.shape = shape;
    // Four corners share the load of one contact, so the overlap is weight over stiffness at most.
    brick.position = {0.2 - half - beside, 0.1, half - weight / 1e6};
    world.particles.add(comm.root() ? std::vector{brick} : std::vector<dem::NewParticle>{});
    world.walls.build(0.2);
    for (Surface& wall : world.walls.surfaces())
      if (wall.name.ends_with(".upper")) wall.material = deck.material("oil");
    world.register_surfaces();
    world.particles.set_local_damping(0.5);  // damps oscillations, does not affect equilibrium
    step = world.particles.stable_step();
  }
  void run(double until) {
    for (; time < until; time += substeps * step) {
      const double dt = substeps * step;
      move_walls(world, 0, time, dt);
      world.coupler.publish();
      world.particles.advance(dt, substeps);
      const dem::SurfaceAction& did = world.particles.surface_action();
      world.coupler.collect(substeps, dt, {did.force, did.moment, did.work});
    }
  }
  static constexpr int substeps = 10;
  World world;
  double step = 0, time = 0;
};

TEST(AShearedBrick, LoadsTheUpperHalfWithFrictionTimesWeight) {
  const par::Comm comm = par::Comm::world();
  const Model deck = model();
  Scene scene(comm, deck, 0);
  const double weight = density * 8 * half * half * half * 9.81;  // N
  scene.run(0.15);
  EXPECT_EQ(comm.sum(std::int64_t{scene.world.particles.trouble().empty() ? 0 : 1}), 0);
  constexpr double settled = 1e-3;  // remainder of the initial oscillation
  EXPECT_NEAR(scene.world.force_on(scene.world.wall("wall.right.upper")).x(), mu * weight,
              settled * weight);
  EXPECT_NEAR(scene.world.force_on(scene.world.wall("floor")).x(), -mu * weight, settled * weight);
  EXPECT_NEAR(scene.world.force_on(scene.world.wall("floor")).z(), -weight, settled * weight);
  EXPECT_EQ(scene.world.force_on(scene.world.wall("wall.left.lower")).norm(), 0);
  EXPECT_EQ(scene.world.force_on(scene.world.wall("nowhere")).norm(), 0);
  constexpr double closed = 1e-10;  // accuracy of the coupling
  EXPECT_LT(scene.world.coupler.balance().force, closed);
  EXPECT_LT(scene.world.coupler.balance().work, closed);
}

// Sums of loads have a range of eight times the largest load seen, and give the same force.
TEST(IncreasingLoads, GetACoarserQuantumInTime) {
  const par::Comm comm = par::Comm::world();
  const Model deck = model();
  Scene scene(comm, deck, 0);
  const double weight = density * 8 * half * half * half * 9.81;  // N
  scene.run(0.05);
  const Surface& floor = scene.world.walls.surfaces()[0];
  const double before = floor.load_quantum;
  scene.world.particles.expect_load(scene.world.coupler.largest_load());
  EXPECT_EQ(floor.load_quantum, before);  // a brick's weight is far below the largest force
  const double capacity = std::ldexp(before, 63);
  scene.world.particles.expect_load(capacity);
  EXPECT_GE(std::ldexp(floor.load_quantum, 63), 8 * capacity);
  scene.run(0.15);
  EXPECT_NEAR(scene.world.force_on(scene.world.wall("floor")).z(), -weight, 1e-3 * weight);
  EXPECT_EQ(scene.world.coupler.trouble(), "");
}

TEST(TheLowerHalf, MovesByTheDisplacementOfTheStageAndStops) {
  const par::Comm comm = par::Comm::world();
  const Model deck = model();
  Scene scene(comm, deck, 0.1);
  scene.run(0.2);
  const double dt = Scene::substeps * scene.step;
  EXPECT_NEAR(scene.world.walls.displacement("floor").x(), 0.02, 1e-12);
  move_walls(scene.world, 0, 0.3, dt);  // beyond the end
  EXPECT_EQ(scene.world.walls.surfaces()[0].motion[0].norm(), 0);
  // Full speed v = D/(T - r/2) after the ramp r, none before it.
  Scene other(comm, deck, 0.1);
  move_walls(other.world, 0, 0.1, dt);
  EXPECT_NEAR(other.world.walls.surfaces()[0].motion[0].x() / dt, 0.02 / (0.2 - 0.025), 1e-9);
  Scene begun(comm, deck, 0.1);
  move_walls(begun.world, 0, 0, dt);
  EXPECT_LT(begun.world.walls.surfaces()[0].motion[0].x() / dt, 1e-3);
}

TEST(StonesBesideTheFloor, AreRemovedAndNoOthers) {
  const par::Comm comm = par::Comm::world();
  const Model deck = model();
  Scene scene(comm, deck, 0.1);
  std::vector<dem::NewParticle> more;
  for (const double x : {-0.04, -0.06, 0.24, 0.26}) {
    dem::NewParticle stone;
    stone.id = static_cast<Id>(more.size()) + 1;
    stone.position = {x, 0.1, 1};
    more.push_back(stone);
  }
  scene.world.particles.add(comm.root() ? more : std::vector<dem::NewParticle>{});
  Clock clock(0.01, 10);
  clock.tick();
  clear_beside_floor(scene.world, clock);
  EXPECT_EQ(scene.world.particles.totals().particles, 3);
}

}  // namespace
}  // namespace trackbed::model::shear_test
