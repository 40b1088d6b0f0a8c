// A surface distributed randomly over ranks is bitwise identical to one on a single rank, and the
// loads of its nodes have the force, moment and work of the contacts.
#include "trackbed/couple/coupler.hpp"

#include <gtest/gtest.h>

#include "trackbed/core/exact_sum.hpp"
#include "trackbed/core/hash.hpp"

namespace trackbed::couple::coupler_test {
namespace {

// 20 cells x 3 nodes along y: forces up to 1e3 N with a quantum of 2^-20 N.
// Rounding of 200 terms to half a quantum each, over a scale of about 1e5 N: 1e-9 at most.
constexpr double quantised = 1e-9;
// The same sums without significant rounding to quanta: a few bits of double precision.
constexpr double rounding = 1e-14;
constexpr int cells = 20, rows = 3, steps = 7;
constexpr double dt = 1e-3;

double draw(std::uint64_t seed, std::uint64_t key) { return 2 * uniform(seed, key) - 1; }
Vec3 draw_vector(std::uint64_t seed, std::uint64_t key) {
  return {draw(seed, 3 * key), draw(seed, 3 * key + 1), draw(seed, 3 * key + 2)};
}

Surface strip() {
  Surface surface;
  surface.name = "strip";
  surface.load_quantum = std::ldexp(1.0, -20);
  for (int i = 0; i <= cells; ++i)
    for (int j = 0; j < rows; ++j) surface.position.emplace_back(i, j, 0.1 * draw(1, 3 * i + j));
  for (int i = 0; i < cells; ++i)
    for (int j = 0; j + 1 < rows; ++j) {
      const int a = i * rows + j, b = a + rows;
      surface.triangles.push_back({a, b, b + 1});
      surface.triangles.push_back({a, b + 1, a + 1});
    }
  for (std::size_t n = 0; n < surface.nodes(); ++n)
    surface.motion.push_back(1e-3 * draw_vector(2, n));
  return surface;
}

struct Contact {
  std::size_t triangle;
  Vec3 shape;  // shape functions
  Vec3 force;
  int step;  // 1..steps
};

std::vector<Contact> contacts(const Surface& surface, std::size_t count, std::uint64_t seed) {
  std::vector<Contact> all;
  for (std::size_t k = 0; k < count; ++k) {
    const double a = uniform(seed, 4 * k), b = uniform(seed, 4 * k + 1) * (1 - a);
    all.push_back({static_cast<std::size_t>(uniform(seed, 4 * k + 2) *
                                            static_cast<double>(surface.triangles.size())),
                   Vec3(a, b, 1 - a - b), 1e3 * draw_vector(seed + 1, k),
                   1 + static_cast<int>(uniform(seed, 4 * k + 3) * steps)});
  }
  return all;
}

// Distributes a contact force to the nodes as the particles do and returns its action at the
// contact point.
Action apply(const Contact& contact, Surface& surface) {
  Action action{contact.force, Vec3::Zero(), 0};
  Vec3 point = Vec3::Zero();
  const double s = static_cast<double>(contact.step) / steps;
  for (int i = 0; i < 3; ++i) {
    const auto n =
        static_cast<std::size_t>(surface.triangles[contact.triangle][static_cast<std::size_t>(i)]);
    const Vec3 force = contact.shape[i] * contact.force;
    point += contact.shape[i] * (surface.position[n] + s * surface.motion[n]);
    action.work += force.dot(surface.motion[n]) / steps;
    for (std::size_t k = 0; k < 3; ++k) {
      const double f = force[static_cast<int>(k)] / surface.load_quantum;
      surface.load[n].force[k] += std::llrint(f);
      surface.load[n].first[k] += std::llrint(s * f);
    }
  }
  action.moment = point.cross(contact.force);
  return action;
}

bool everywhere(const Vec3&, const Vec3&) { return true; }

class CouplerTest : public ::testing::Test {
 protected:
  // Owners move the nodes; all other ranks start with a wrong motion.
  std::vector<int> scatter(Surface& surface, std::uint64_t seed) const {
    std::vector<int> owner;
    for (std::size_t n = 0; n < surface.nodes(); ++n) {
      owner.push_back(static_cast<int>(uniform(seed, n) * world.size()));
      if (owner.back() != world.rank()) surface.motion[n] = Vec3(9, 9, 9);
    }
    return owner;
  }
  // Contacts are distributed to ranks randomly; the action is equal on all ranks, as that of the
  // particles.
  Action touch(const std::vector<Contact>& all, Surface& surface, Surface& reference) const {
    Action total{Vec3::Zero(), Vec3::Zero(), 0};
    for (std::size_t k = 0; k < all.size(); ++k) {
      const Action one = apply(all[k], reference);
      total.force += one.force, total.moment += one.moment, total.work += one.work;
      if (static_cast<int>(mix(k) % static_cast<std::uint64_t>(world.size())) == world.rank())
        apply(all[k], surface);
    }
    return total;
  }
  const par::Comm world = par::Comm::world();
};

TEST_F(CouplerTest, RandomOwnersAreBitwiseIdenticalToOneRank) {
  Surface reference = strip(), surface = strip();
  reference.clear_load();
  Coupler coupler(world);
  const std::vector<int> owner = scatter(surface, 5);
  const std::size_t number = coupler.add(surface, owner);
  coupler.connect(everywhere);
  coupler.publish();
  for (std::size_t n = 0; n < surface.nodes(); ++n) {
    EXPECT_EQ(surface.position[n], reference.position[n]) << n;
    EXPECT_EQ(surface.motion[n], reference.motion[n]) << n;
  }
  const Action action = touch(contacts(reference, 200, 7), surface, reference);
  coupler.collect(steps, dt, action);
  for (std::size_t n = 0; n < surface.nodes(); ++n) {
    if (owner[n] != world.rank()) continue;
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_EQ(coupler.mean_force(number)[n][static_cast<int>(k)],
                static_cast<double>(reference.load[n].force[k]) * (reference.load_quantum / steps));
  }
  EXPECT_EQ(surface.load[0].force[0], 0);
}

TEST_F(CouplerTest, NodesReceiveForceMomentAndWorkOfTheContacts) {
  Surface reference = strip(), surface = strip(), plate = strip(), plate_reference = strip();
  reference.clear_load();
  plate_reference.clear_load();
  Coupler coupler(world);
  coupler.add(surface, scatter(surface, 5));
  const std::size_t number = coupler.add(plate);  // no owners: each rank receives the whole load
  coupler.connect(everywhere);
  Action action = touch(contacts(reference, 200, 7), surface, reference);
  const Action more = touch(contacts(reference, 100, 8), plate, plate_reference);
  action.force += more.force, action.moment += more.moment, action.work += more.work;
  coupler.collect(steps, dt, action);
  const Balance& balance = coupler.balance();
  EXPECT_LT(balance.force, quantised);
  EXPECT_LT(balance.moment, quantised);
  EXPECT_LT(balance.work, quantised);
  EXPECT_LT(balance.impulse, quantised);
  for (std::size_t n = 0; n < plate.nodes(); ++n)
    EXPECT_EQ(coupler.mean_force(number)[n].x(),
              static_cast<double>(plate_reference.load[n].force[0]) *
                  (plate_reference.load_quantum / steps));
}

TEST_F(CouplerTest, ALostLoadIsDetected) {
  Surface surface = strip(), reference = strip();
  reference.clear_load();
  Coupler coupler(world);
  coupler.add(surface);
  coupler.collect(steps, dt, {Vec3::Zero(), Vec3::Zero(), 0});
  EXPECT_EQ(coupler.balance().force, 0);  // no contact
  EXPECT_EQ(coupler.largest_load(), 0);
  EXPECT_EQ(coupler.trouble(), "");
  const std::vector<Contact> one = contacts(reference, 1, 9);
  Action action = touch(one, surface, reference);
  action.force *= 2;
  action.work *= 2;
  action.moment *= 2;
  coupler.collect(steps, dt, action);
  constexpr double half = 0.5;  // half is missing, relative to the larger; parallel node forces
  EXPECT_NEAR(coupler.balance().force, half, quantised);
  EXPECT_NEAR(coupler.balance().impulse, half, quantised);
  EXPECT_GT(coupler.balance().moment, 0.01);
  EXPECT_GT(coupler.balance().work, 0.01);
  EXPECT_NE(coupler.trouble().find("relative error of 0.5 (allowed:"), std::string::npos)
      << coupler.trouble();
}

// Less than half a quantum on each node, and a few quanta: rounding is a large part of it.
TEST_F(CouplerTest, RoundingOfSmallForcesIsNoLoss) {
  for (const double quanta : {0.3, 2.4, 1e3}) {
    Surface surface = strip(), reference = strip();
    reference.clear_load();
    Coupler coupler(world);
    coupler.add(surface);
    std::vector<Contact> one = contacts(reference, 1, 9);
    one[0].force *= quanta * surface.load_quantum / one[0].force.norm();
    coupler.collect(steps, dt, touch(one, surface, reference));
    EXPECT_EQ(coupler.trouble(), "") << quanta;
    EXPECT_EQ(coupler.balance().force, 0) << quanta;
  }
}

TEST_F(CouplerTest, OneNodeIsExactToRounding) {
  Surface surface = strip();
  Coupler coupler(world);
  coupler.add(surface);
  if (world.root()) surface.load[4] = {{1 << 20, 2 << 20, 3 << 20}, {1 << 19, 1 << 20, 3 << 19}};
  const Vec3 force(1, 2, 3);  // N, all at mid-window
  const Vec3 point = surface.position[4] + 0.5 * surface.motion[4];
  coupler.collect(steps, dt, {force, point.cross(force), force.dot(surface.motion[4]) / steps});
  EXPECT_LT(coupler.balance().moment, rounding);
  EXPECT_LT(coupler.balance().work, rounding);
  EXPECT_EQ(coupler.largest_load(), 3);
  EXPECT_EQ(coupler.trouble(), "");
}

TEST_F(CouplerTest, OnlyNodesWithinReachAreSent) {
  Surface surface = strip();
  Coupler coupler(world);
  const std::size_t number = coupler.add(surface, std::vector<int>(surface.nodes(), 0));
  // Each rank r has stones over x in [4r + 1.2, 4r + 1.8]: one cell, one ring to either side.
  const double from = 4 * world.rank() + 1.2, to = from + 0.6;
  coupler.connect(
      [&](const Vec3& low, const Vec3& high) { return low.x() < to && high.x() > from; });
  const std::size_t expected = world.root() ? 0 : 4 * rows;
  EXPECT_EQ(coupler.received(number), expected);
  for (int window = 0; window < 3; ++window) {
    if (world.root())
      for (auto& motion : surface.motion) motion = Vec3(0, 0, 1e-3 * (window + 1));
    coupler.publish();
    const auto node = static_cast<std::size_t>(rows * static_cast<int>(from));
    EXPECT_EQ(surface.motion[node].z(), 1e-3 * (window + 1));
  }
}

TEST_F(CouplerTest, MeanForceIsSavedAndLoaded) {
  Surface surface = strip(), reference = strip();
  reference.clear_load();
  Coupler coupler(world), other(world);
  const std::vector<int> owner = scatter(surface, 6);
  coupler.add(surface, owner);
  coupler.connect(everywhere);
  const Action action = touch(contacts(reference, 50, 3), surface, reference);
  coupler.collect(steps, dt, action);
  std::vector<double> all;
  for (const Vec3& f : coupler.save_mean(0)) all.insert(all.end(), f.data(), f.data() + 3);
  world.sum(std::span(all));
  std::vector<Vec3> mean;
  for (std::size_t n = 0; n < surface.nodes(); ++n) mean.emplace_back(&all[3 * n]);
  other.add(surface, owner);
  other.load_mean(0, mean);
  for (std::size_t n = 0; n < surface.nodes(); ++n)
    if (owner[n] == world.rank()) {
      EXPECT_EQ(other.mean_force(0)[n], coupler.mean_force(0)[n]);
    }
}

}  // namespace
}  // namespace trackbed::couple::coupler_test
