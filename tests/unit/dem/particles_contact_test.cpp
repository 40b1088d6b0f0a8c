// Contacts of particles with each other: balances, neighbour search, checks of the input.
#include <gtest/gtest.h>

#include <set>

#include "support/scene.hpp"
#include "trackbed/core/error.hpp"

namespace trackbed::particles_contact_test {
namespace {

dem::ContactLaw elastic(double friction = 0) {
  dem::ContactLaw law;
  law.k_n = law.k_s = 1e6;
  law.friction = friction;
  return law;
}

dem::Parameters weightless() {
  dem::Parameters p;
  p.gravity = 0;
  return p;
}

// Energy error of one collision of two clumps at dt = fraction * sqrt(m/k), over the energy.
double energy_error(double fraction, std::uint64_t seed) {
  dem::Particles p(par::Comm::self(), test::one_material(elastic()), weightless(),
                   test::box(Vec3::Constant(-1), Vec3::Constant(1)));
  p.add_template(test::clump());
  std::vector<dem::NewParticle> two(2);
  for (int k = 0; k < 2; ++k) {
    const auto key = seed * 2 + static_cast<std::uint64_t>(k);
    dem::NewParticle& n = two[static_cast<std::size_t>(k)];
    n.id = k;
    n.scale = 0.02;
    n.position = Vec3(k ? 0.045 : -0.045, 0.01 * (uniform(1, key) - 0.5), 0);
    n.velocity = Vec3(k ? -0.5 : 0.5, 0, 0);
    n.spin = 20 * Vec3(uniform(2, key) - 0.5, uniform(3, key) - 0.5, uniform(4, key) - 0.5);
    n.attitude = Quat(uniform(5, key), uniform(6, key), uniform(7, key), 0.3).normalized();
  }
  p.add(two);
  const double before = p.totals().kinetic;
  const double dt = fraction * std::sqrt(p[0].mass / 1e6);
  const int steps = static_cast<int>(0.2 / dt);
  p.advance(steps * dt, steps);
  EXPECT_EQ(p.totals().contacts, 0);                                       // separate again
  EXPECT_LT((p[0].velocity - Vec3(0.5, 0, 0)).dot(Vec3(1, 0, 0)), -0.01);  // they have collided
  return std::abs(p.totals().kinetic - before) / before;
}

TEST(Contact, CollisionsOfClumpsKeepEnergyToSecondOrder) {
  double coarse = 0, fine = 0;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    coarse += energy_error(0.1, seed);
    fine += energy_error(0.025, seed);
  }
  constexpr double largest_mean = 2e-3;  // a few pebbles touch in turn; each like (dt w)^2 / 12
  EXPECT_LT(coarse / 12, largest_mean);
  const double order = std::log(coarse / fine) / std::log(4.0);
  EXPECT_GT(order, 1.6);  // second, less the effect of opening and closing contacts
  EXPECT_LT(order, 4);    // collisions with one contact and corrected ends, of third, add to it
}

TEST(Contact, FreeRotationKeepsEnergyAndMomentum) {
  const auto drift = [](double dt) {
    dem::Particles p(par::Comm::self(), test::one_material(elastic()), weightless(),
                     test::box(Vec3::Constant(-1), Vec3::Constant(1)));
    p.add_template(test::clump());
    dem::NewParticle n;
    n.scale = 0.05;
    n.spin = Vec3(3, 40, 5);
    p.add(std::span(&n, 1));
    const double energy = p.totals().kinetic;
    double largest = 0;
    for (int k = 0; k < 200; ++k) {
      p.advance(0.01, static_cast<int>(std::lround(0.01 / dt)));
      largest = std::max(largest, std::abs(p.totals().kinetic - energy) / energy);
      EXPECT_NEAR(p[0].attitude.norm(), 1, 1e-15);
    }
    return largest;
  };
  const double coarse = drift(1e-3), fine = drift(5e-4);
  EXPECT_LT(coarse, 1e-3);
  EXPECT_NEAR(std::log2(coarse / fine), 2.0, 0.3);
}

TEST(Contact, CellsFindWhatBruteForceFinds) {
  dem::Domain domain = test::box({0, 0, 0}, {0.2, 0.2, 0.2});
  domain.periodic = {true, true, true};
  dem::Particles p(par::Comm::self(), test::one_material(elastic()), weightless(), domain);
  p.add_template(test::clump());
  p.add_template(test::sphere());
  auto all = test::lattice({8, 8, 8}, 0.025, 0.014, 2);
  p.add(all);
  p.advance(1e-9, 1);
  struct Sphere {
    Id id;
    Vec3 x;
    double r;
  };
  std::vector<Sphere> pieces;
  for (std::size_t i = 0; i < p.size(); ++i)
    p.pieces(i, [&](const Vec3& c, double r) { pieces.push_back({p[i].id, c, r}); });
  std::int64_t brute = 0;
  for (std::size_t a = 0; a < pieces.size(); ++a)
    for (std::size_t b = a + 1; b < pieces.size(); ++b) {
      if (pieces[a].id == pieces[b].id) continue;
      Vec3 d = pieces[b].x - pieces[a].x;
      for (int k = 0; k < 3; ++k) d[k] -= 0.2 * std::round(d[k] / 0.2);
      brute += d.norm() < pieces[a].r + pieces[b].r;
    }
  EXPECT_GT(brute, 250);
  EXPECT_EQ(p.totals().contacts, brute);
}

TEST(Contact, MomentumIsKept) {
  dem::ContactLaw law = elastic(0.5);
  law.zeta_n = law.zeta_s = 0.3;
  dem::Domain domain = test::box({0, 0, 0}, {0.2, 0.2, 0.2});
  domain.periodic = {true, true, true};
  dem::Particles p(par::Comm::self(), test::one_material(law), weightless(), domain);
  p.add_template(test::clump());
  p.add_template(test::sphere());
  p.add(test::lattice({8, 8, 8}, 0.025, 0.014, 2));
  const Vec3 before = p.totals().momentum;
  p.advance(1e-9, 1);
  EXPECT_GT(p.totals().contacts, 100);
  p.advance(0.02, 1000);
  EXPECT_LT((p.totals().momentum - before).norm(), 1e-12);  // kg m/s, of about 1
}

// Two pairs of spheres side by side have two contacts and are one neighbour of each other; the
// floor is a neighbour of the lower one.
TEST(Contact, NeighboursAreCountedOnceContactsByPieces) {
  dem::Template pair;
  pair.pieces = {geom::ball({-0.6, 0, 0}, 0.5), geom::ball({0.6, 0, 0}, 0.5)};
  pair.volume = 1, pair.gyration = Vec3(0.1, 0.4, 0.4);
  dem::Particles p(par::Comm::self(), test::one_material(elastic()), weightless(),
                   test::box(Vec3::Constant(-2), Vec3::Constant(4)));
  p.add_template(pair);
  Surface floor = test::floor_of(1, 2);
  p.set_surfaces({&floor});
  std::vector<dem::NewParticle> two(2);
  two[0].position = Vec3(0, 0, 0.4999);
  two[1].id = 1, two[1].position = Vec3(0, 0, 1.4998);
  p.add(two);
  p.advance(1e-9, 1);
  const dem::Totals totals = p.totals();
  EXPECT_EQ(totals.contacts, 4);
  EXPECT_EQ(p.neighbours(), 3);
  const dem::Memory memory = p.memory();
  EXPECT_GT(memory.particles, 2 * 10 * sizeof(double));  // pose and motion
  EXPECT_GT(memory.contacts, 0u);
  EXPECT_EQ(memory.total(), memory.particles + memory.contacts);
}

TEST(Contact, PiecesThatCannotMoveAreRefused) {
  dem::Particles p(par::Comm::self(), test::one_material({}), {},
                   test::box(Vec3::Zero(), Vec3::Ones()));
  dem::Template sharp = test::sphere(), empty = test::sphere();
  sharp.pieces[0].radius = 0;
  empty.pieces[0].core.vertices.clear();
  EXPECT_THROW(p.add_template(sharp), InputError);
  EXPECT_THROW(p.add_template(empty), InputError);
}

TEST(Contact, AMissingLawIsNamed) {
  dem::Physics physics = test::one_material(elastic());
  physics.materials.push_back({.name = "rubber"});
  dem::Particles p(par::Comm::self(), physics, {}, test::box(Vec3::Constant(-1), Vec3::Ones()));
  p.add_template(test::sphere(0.01));
  std::vector<dem::NewParticle> two(2), one(1);
  two[1].id = 1, two[1].material = 1, two[1].position = Vec3(0.5, 0, 0);
  one[0].id = 2, one[0].material = 1, one[0].position = Vec3(-0.5, 0, 0);
  const auto refused = [&](const std::vector<dem::NewParticle>& more) -> std::string {
    try {
      p.add(more);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  // A single stone of a material cannot touch another one of it.
  const std::string between = "contact: no law is given between \"stone\" and \"rubber\"";
  EXPECT_EQ(refused(two), between);
  EXPECT_EQ(refused(one), between + "\ncontact: no law is given between \"rubber\" and \"rubber\"");
}

// A law's number must fit into the byte that a list entry has for it.
TEST(Contact, MoreLawsThanAnEntryCanNameAreRefused) {
  dem::Physics physics;
  for (int m = 0; m < 23; ++m) {
    physics.materials.push_back({.name = std::to_string(m)});
    for (int other = 0; other <= m; ++other)
      physics.laws.push_back({.first = std::to_string(m), .second = std::to_string(other)});
  }
  const auto build = [&] {
    dem::Particles(par::Comm::self(), physics, {}, test::box(Vec3::Zero(), Vec3::Ones()));
  };
  EXPECT_THROW(build(), InputError);  // 276
  physics.laws.resize(256);
  EXPECT_NO_THROW(build());
}

TEST(Contact, LostAndOverlappingParticlesAreReported) {
  dem::Particles p(par::Comm::self(), test::one_material(elastic()), {},
                   test::box(Vec3::Constant(-1), Vec3::Ones()));
  p.add_template(test::sphere(0.01));
  dem::NewParticle n;
  n.velocity = Vec3(0, 0, -100);
  p.add(std::span(&n, 1));
  p.advance(0.02, 20);
  EXPECT_EQ(p.trouble().rfind("particle 0 left the domain at (0, 0, -", 0), 0u);
  std::vector<dem::NewParticle> two(2);
  two[0].id = 1, two[1].id = 2;
  two[1].position = Vec3(0.005, 0, 0);
  p.add(two);
  p.remove([](const dem::ParticleView& view) { return view.id == 0; });
  p.advance(1e-6, 1);
  EXPECT_EQ(p.trouble().rfind("two stones overlap by 1.5 times the smaller radius", 0), 0u);
}

// A ball held between two others spins about the line of centres and a little across it. Energy per
// initial energy after `seconds`.
double energy_of_a_turning_contact(dem::ContactLaw law, double seconds, double dt) {
  constexpr double r = 0.01;  // m
  law.k_n = 1e5, law.k_s = 0.8e5, law.friction = 5;
  dem::Particles p(par::Comm::self(), test::one_material(law), {.gravity = 0},
                   test::box(Vec3::Constant(-1), Vec3::Constant(1)));
  p.add_template(test::sphere(r));
  std::vector<dem::NewParticle> three(3);
  three[0].spin = Vec3(9, 3, 150);  // rad/s
  for (std::size_t k : {1, 2}) {
    three[k].id = static_cast<std::int64_t>(k), three[k].held = true;
    three[k].position.z() = (k == 1 ? 1 : -1) * 1.99 * r;
  }
  p.add(three);
  const auto energy = [&] { return p.totals().kinetic + p.totals().elastic; };
  p.advance(1e-12, 1);
  const double before = energy();
  const int steps = static_cast<int>(seconds / dt);
  p.advance(steps * dt, steps);
  EXPECT_EQ(p.trouble(), "");
  return energy() / before;
}

TEST(Contact, TurningAboutItsNormalALastingContactGainsNoEnergy) {
  const double root = std::sqrt(2500 * 4.0 / 3.0 * M_PI * 1e-6 / 1e5);  // s, sqrt(m / k_n)
  for (const bool rolls : {false, true}) {
    dem::ContactLaw law;
    if (rolls) law.rolling_friction = 5, law.rolling_stiffness = 0.5;
    const double gained = energy_of_a_turning_contact(law, 1500 * root, 0.2 * root);
    std::printf("energy over the initial energy: %.6f\n", gained);
    EXPECT_LT(gained, 1.001);
  }
}

}  // namespace
}  // namespace trackbed::particles_contact_test
