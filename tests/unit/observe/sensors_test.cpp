// Sensors in a bed read the stones that they are to read.
#include "trackbed/observe/sensors.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "support/scene.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::sensors_test {
namespace {

constexpr double r = 0.02, spacing = 0.1, dt = 1e-3;  // m, m, s
constexpr double gravity = 2;                         // m/s^2

// Balls far from each other in a box periodic in x, each with a velocity of its own, in free fall.
struct Balls {
  std::vector<dem::NewParticle> all;
  dem::Particles particles;

  explicit Balls(const par::Comm& comm)
      : particles(comm, test::one_material(law()), {.gravity = gravity}, domain()) {
    particles.add_template(test::sphere());
    for (int i = 0; i < 8; ++i)
      for (int j = 0; j < 3; ++j)
        for (int k = 0; k < 4; ++k) {
          dem::NewParticle p;
          p.id = 7 * static_cast<Id>(all.size()) + 3;
          p.scale = r;
          p.position = spacing * Vec3(i + 0.5, j - 1, k + 0.5);
          p.velocity = Vec3(0.1 * i, -0.05 * j, 0.02 * k);
          all.push_back(p);
        }
    particles.add(test::mine(comm, all));
  }
  static dem::ContactLaw law() {
    dem::ContactLaw springs;
    springs.k_n = springs.k_s = 1e4;
    return springs;
  }
  static dem::Domain domain() {
    dem::Domain domain = test::box({0, -0.5, -0.5}, {8 * spacing, 0.5, 0.5});
    domain.periodic = {true, false, false};
    return domain;
  }
  void fall(int steps) { particles.advance(steps * dt, steps); }
  static const dem::NewParticle& at(const std::vector<dem::NewParticle>& all, int i, int j, int k) {
    return all[static_cast<std::size_t>((i * 3 + j) * 4 + k)];
  }
};

observe::Sensor sensor(observe::SensorKind kind, const Vec3& at, double radius,
                       const std::string& stage = "") {
  observe::Sensor one;
  one.name = "s";
  one.kind = kind, one.radius = radius, one.stage = stage;
  one.at = {at.x(), at.y(), at.z()};
  return one;
}

using observe::SensorKind;
// Means are quotients of exact sums, whose error is below 1e-15 of the largest term.
constexpr double rounding = 1e-12;

class Sensors : public testing::Test {
 protected:
  par::Comm comm = par::Comm::world();
  Balls balls{comm};
  std::vector<observe::Sensor> list;
};

TEST_F(Sensors, FollowTheNearestStone) {
  const dem::NewParticle& stone = Balls::at(balls.all, 2, 1, 3);
  list = {sensor(SensorKind::stones, stone.position + Vec3(0.02, -0.01, 0.03), 0)};
  observe::Sensors sensors(comm, list, gravity);
  EXPECT_EQ(sensors.read(&balls.particles, nullptr)[0].stones, 0) << "none is chosen yet";
  sensors.begin_stage("other", false, balls.particles);
  EXPECT_EQ(sensors.read(&balls.particles, nullptr)[0].stones, 0);
  sensors.begin_stage("last", true, balls.particles);
  balls.fall(20);
  const observe::SensorReading reading = sensors.read(&balls.particles, nullptr)[0];
  EXPECT_EQ(reading.stones, 1);
  const double time = 20 * dt;
  const Vec3 moved = time * stone.velocity - Vec3(0, 0, gravity * time * time / 2);
  EXPECT_LT((reading.displacement - moved).norm(), rounding);
  EXPECT_LT((reading.position - stone.position - moved).norm(), rounding);
  EXPECT_LT((reading.acceleration + Vec3(0, 0, gravity)).norm(), rounding);
  EXPECT_NEAR(reading.velocity.z(), stone.velocity.z() - gravity * time, rounding);
}

// Across the periodic end, and in the stage that is named.
TEST_F(Sensors, FollowAllStonesWithinARadius) {
  list = {sensor(SensorKind::stones, {0, 0, spacing / 2}, 0.6 * spacing, "load")};
  observe::Sensors sensors(comm, list, gravity);
  EXPECT_TRUE(sensors.begin_stage("load", false, balls.particles).empty());
  balls.fall(10);
  sensors.begin_stage("last", true, balls.particles);  // does not choose again
  const observe::SensorReading reading = sensors.read(&balls.particles, nullptr)[0];
  const dem::NewParticle &one = Balls::at(balls.all, 0, 1, 0),
                         &other = Balls::at(balls.all, 7, 1, 0);
  EXPECT_EQ(reading.stones, 2);
  EXPECT_NEAR(reading.velocity.x(), (one.velocity + other.velocity).x() / 2, rounding);
  EXPECT_NEAR(reading.displacement.x(), 10 * dt * (one.velocity + other.velocity).x() / 2,
              rounding);
  balls.particles.remove([&](const dem::ParticleView& p) { return p.id == one.id; });
  const observe::SensorReading later = sensors.read(&balls.particles, nullptr)[0];
  EXPECT_EQ(later.stones, 1) << "a stone was removed";
  EXPECT_NEAR(later.velocity.x(), other.velocity.x(), rounding);
}

// A ball that overlaps a floor: its acceleration is that of contact force and gravity.
TEST_F(Sensors, ReadTheAccelerationByContacts) {
  dem::Particles one(comm, test::one_material(Balls::law()), {.gravity = gravity},
                     test::box({-1, -1, -1}, {1, 1, 1}));
  one.add_template(test::sphere());
  std::vector<dem::NewParticle> ball(1);
  ball[0].scale = r, ball[0].position = {0, 0, r - 1e-4};
  one.add(test::mine(comm, ball));
  Surface floor = test::floor_of(1, 0.5);
  one.set_surfaces({&floor});
  one.advance(1e-9, 1);
  list = {sensor(SensorKind::stones, {0, 0, 0}, 0)};
  observe::Sensors sensors(comm, list, gravity);
  sensors.begin_stage("last", true, one);
  const double mass = 2500 * 4.0 / 3 * M_PI * r * r * r;
  const double expected = 1e4 * 1e-4 / mass - gravity;  // k_n times overlap
  EXPECT_NEAR(sensors.read(&one, nullptr)[0].acceleration.z(), expected, 1e-6 * expected);
}

TEST_F(Sensors, SayIfNoStoneIsNear) {
  list = {sensor(SensorKind::stones, {0.1, 0, 0.1}, 1e-6)};
  observe::Sensors sensors(comm, list, gravity);
  const std::vector<std::string> warnings = sensors.begin_stage("last", true, balls.particles);
  ASSERT_EQ(warnings.size(), 1);
  EXPECT_NE(warnings[0].find("within 1e-06 m of [0.1, 0, 0.1] m"), std::string::npos);
  EXPECT_TRUE(std::isnan(sensors.read(&balls.particles, nullptr)[0].displacement.x()));
}

TEST_F(Sensors, ReadTheStonesThatPassAPlace) {
  const dem::NewParticle& stone = Balls::at(balls.all, 6, 1, 2);
  list = {sensor(SensorKind::place, stone.position + Vec3(0.01, 0, 0), 0.02)};
  observe::Sensors sensors(comm, list, gravity);
  EXPECT_EQ(sensors.read(&balls.particles, nullptr)[0].stones, 1);
  EXPECT_NEAR(sensors.read(&balls.particles, nullptr)[0].velocity.x(), stone.velocity.x(),
              rounding);
  balls.fall(60);  // 36 mm along x
  const observe::SensorReading reading = sensors.read(&balls.particles, nullptr)[0];
  EXPECT_EQ(reading.stones, 0);
  EXPECT_TRUE(std::isnan(reading.velocity.x()) && std::isnan(reading.position.z()));
}

// Stones leave the place and others come: their motion from row to row is that of free fall.
TEST_F(Sensors, SumUpTheMotionAtAPlace) {
  const Vec3 place(0.5, 0, 0.2);
  const double radius = 0.12;
  list = {sensor(SensorKind::place, place, radius, "load")};
  observe::Sensors sensors(comm, list, gravity);
  const auto displacement = [&] { return sensors.read(&balls.particles, nullptr)[0].displacement; };
  EXPECT_TRUE(std::isnan(displacement().x())) << "its stage has not begun";
  EXPECT_TRUE(sensors.begin_stage("load", false, balls.particles).empty());
  EXPECT_EQ(displacement(), Vec3(0, 0, 0));
  const auto at = [](const dem::NewParticle& ball, double time) {
    return Vec3(ball.position + time * ball.velocity - Vec3(0, 0, gravity * time * time / 2));
  };
  Vec3 expected = Vec3::Zero();
  std::set<std::size_t> seen;
  constexpr int steps = 20;
  for (int row = 0; row < 10; ++row) {
    const double before = row * steps * dt, now = before + steps * dt;
    Vec3 sum = Vec3::Zero();
    int near = 0;
    for (const dem::NewParticle& ball : balls.all) {
      Vec3 from = at(ball, before) - place;
      from.x() -= 8 * spacing * std::round(from.x() / (8 * spacing));
      if (from.norm() >= radius) continue;
      sum += at(ball, now) - at(ball, before), ++near;
      seen.insert(static_cast<std::size_t>(ball.id));
    }
    ASSERT_GT(near, 0);
    expected += sum / near;
    balls.fall(steps);
    EXPECT_LT((displacement() - expected).norm(), rounding) << row;
  }
  EXPECT_GT(seen.size(), 6) << "stones that have been near";
}

TEST_F(Sensors, GoOnWithTheirStonesAfterACheckpoint) {
  list = {sensor(SensorKind::stones, {0.3, 0, 0.1}, 1.1 * spacing),
          sensor(SensorKind::stones, {0.5, 0, 0.1}, 0, "never"),
          sensor(SensorKind::place, {0.3, 0, 0.1}, spacing)};
  list[1].name = "t", list[2].name = "u";
  const std::string path = "sensors_on_" + std::to_string(comm.size()) + ".h5";
  observe::Sensors sensors(comm, list, gravity), resumed(comm, list, gravity);
  sensors.begin_stage("last", true, balls.particles);
  sensors.read(&balls.particles, nullptr);  // a row before the checkpoint
  balls.fall(30);
  sensors.read(&balls.particles, nullptr);
  {
    io::File file(comm, path, io::Mode::create);
    io::Archive::writer(comm, file).part("sensors", sensors);
  }
  comm.barrier();
  {
    const io::File file(comm, path, io::Mode::read);
    EXPECT_FALSE(file.has("sensors/t"));
    io::Archive::reader(file).part("sensors", resumed);
  }
  comm.barrier();
  if (comm.root()) std::filesystem::remove(path);
  balls.fall(10);
  const auto one = sensors.read(&balls.particles, nullptr),
             other = resumed.read(&balls.particles, nullptr);
  for (const std::size_t k : {0, 2}) {
    EXPECT_GT(one[k].stones, 2);
    EXPECT_EQ(one[k].stones, other[k].stones);
    EXPECT_LT(one[k].displacement.z(), -1e-3);
    EXPECT_EQ(one[k].displacement, other[k].displacement);
  }
}

fem::GroundParameters soil() {
  fem::GroundParameters p;
  p.x = {0, 2}, p.y = {0, 1};
  p.elements_x = 4, p.elements_y = 2, p.elements_z = 2;
  p.layers = {{"all", 1, {50e6, 0.3, 2000}}};
  return p;
}

// Each reads its own point, in the order of the deck, whatever lies between.
TEST_F(Sensors, InTheGroundReadItsMotion) {
  fem::Ground ground(comm, soil(), Dimension::space, 1);
  std::vector<Vec3> load(ground.top().nodes(), Vec3(0, 0, -300));
  ground.settle(load);
  for (std::size_t n = 0; n < load.size(); ++n)
    load[n].z() = -1e3 * (1 + ground.top().position[n].x());
  for (int k = 0; k < 3; ++k) ground.advance(ground.stable_step(), load);
  const Vec3 one(0.6, 0.3, -0.2), other(1.7, 0.8, -0.7);
  list = {sensor(SensorKind::ground, one, 0), sensor(SensorKind::stones, {0, 0, 0}, 0),
          sensor(SensorKind::ground, other, 0)};
  observe::Sensors sensors(comm, list, gravity);
  sensors.locate(ground);
  const auto readings = sensors.read(&balls.particles, &ground);
  const std::vector<Vec3> places{one, other};
  const auto states = ground.states_at(ground.locate(places));
  EXPECT_GT((states[0].displacement - states[1].displacement).norm(), 1e-9);
  for (std::size_t k = 0; k < 2; ++k) {
    const observe::SensorReading& reading = readings[2 * k];
    EXPECT_EQ(reading.displacement, states[k].displacement);
    EXPECT_EQ(reading.velocity, states[k].velocity);
    EXPECT_EQ(reading.acceleration, states[k].acceleration);
    EXPECT_EQ(reading.stress, states[k].stress);
    EXPECT_EQ(reading.stress_static, states[k].stress_static);
    EXPECT_NE(reading.stress_static, reading.stress);
    EXPECT_LT(reading.stress_static[2], -100);  // of weight and load, Pa
  }
  EXPECT_EQ(readings[1].stones, 0);
}

TEST_F(Sensors, InTheGroundMustLieInAnElement) {
  fem::Ground ground(comm, soil(), Dimension::space, 1);
  list = {sensor(SensorKind::ground, {1, 0.5, -0.3}, 0),
          sensor(SensorKind::ground, {1, 0.5, 0.3}, 0), sensor(SensorKind::ground, {5, 0, 0}, 0)};
  observe::Sensors sensors(comm, list, gravity);
  try {
    sensors.locate(ground);
    FAIL();
  } catch (const InputError& error) {
    const std::string words = error.what();
    EXPECT_EQ(words.find("sensor[0]"), words.npos);
    EXPECT_NE(words.find("sensor[1].at = [1, 0.5, 0.3] m"), words.npos) << words;
    EXPECT_NE(words.find("sensor[2]"), words.npos);
  }
}

}  // namespace
}  // namespace trackbed::sensors_test
