// Pairs of stones: the force is the gradient of the energy and continuous, momentum is kept, and
// the description of a shape does not matter.
#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "support/stone_pairs.hpp"
#include "trackbed/core/rotation.hpp"

namespace trackbed::stones_test {
namespace {

constexpr double k = 1e6;      // N/m
constexpr double size = 0.04;  // m
constexpr double r = test::rounding * size;

dem::Particles two(const dem::Template& a, const dem::Template& b,
                   const std::vector<dem::NewParticle>& pair, const dem::ContactLaw& law,
                   Dimension dimension = Dimension::space) {
  dem::Parameters parameters;
  parameters.gravity = 0, parameters.largest_overlap = 1e3;
  dem::Domain domain = test::box(Vec3::Constant(-1), Vec3::Ones());
  domain.dimension = dimension;
  domain.thickness = size;
  dem::Particles p(par::Comm::self(), test::one_material(law), parameters, domain);
  p.add_template(a), p.add_template(b);
  p.add(pair);
  return p;
}

dem::ContactLaw elastic(double friction = 0) {
  dem::ContactLaw law;
  law.k_n = k, law.k_s = friction > 0 ? 0.8 * k : 0;
  law.friction = friction;
  law.attraction = true;
  return law;
}

std::vector<dem::NewParticle> pair_at(const Vec3& second, const Quat& qa = Quat::Identity(),
                                      const Quat& qb = Quat::Identity()) {
  std::vector<dem::NewParticle> pair(2);
  for (int n = 0; n < 2; ++n) pair[static_cast<std::size_t>(n)].id = n;
  for (dem::NewParticle& p : pair) p.scale = size;
  pair[1].shape = 1;
  pair[1].position = second;
  pair[0].attitude = qa, pair[1].attitude = qb;
  return pair;
}

struct Wrenches {
  Vec3 force[2], torque[2];
  double energy;
};

// Wrenches of two particles at rest in this pose.
Wrenches wrenches_of(const dem::Template& a, const dem::Template& b,
                     const std::vector<dem::NewParticle>& pair) {
  dem::Particles p = two(a, b, pair, elastic());
  p.advance(1e-30, 1);
  return {{p[0].force, p[1].force}, {p[0].torque, p[1].torque}, p.totals().elastic};
}

Vec3 draw(std::uint64_t seed, std::uint64_t key) {
  return Vec3(uniform(seed, key), uniform(seed + 1, key), uniform(seed + 2, key)) -
         Vec3::Constant(0.5);
}

Quat any_turn(std::uint64_t seed, std::uint64_t key) {
  const Vec3 v = draw(seed, key);
  return Quat(uniform(seed + 3, key) - 0.5, v.x(), v.y(), v.z()).normalized();
}

dem::Template shape(std::uint64_t key) {
  if (key % 4 == 0) return test::cuboid({0.5, 0.4, 0.3});
  if (key % 4 == 1) return test::compound(key / 4);
  return test::stone(key);
}

// A pose in which two shapes overlap by up to half the sum of their radii of rounding.
std::vector<dem::NewParticle> overlapping(const dem::Template& a, const dem::Template& b,
                                          std::uint64_t key) {
  auto pair = pair_at(2 * size * draw(10, key).normalized(), any_turn(20, key), any_turn(30, key));
  if (key % 3 == 0)  // nearly face to face
    for (std::size_t n = 0; n < 2; ++n) {
      const Vec3 normal = (n ? b : a).pieces[0].core.faces[key % 4].normal;
      const Vec3 to = (n ? -1 : 1) * pair[1].position.normalized() + 0.02 * draw(40 + 3 * n, key);
      pair[n].attitude = rotation_onto(normal, to);
    }
  test::bring_near(a, pair[0], b, pair[1], 0.01 * r);
  pair[1].position -= (0.05 + 0.95 * uniform(50, key)) * r * pair[1].position.normalized();
  return pair;
}

// Largest difference of force and torque (over a length) from the gradient of the energy, over the
// force.
double off_the_slope(const dem::Template& a, const dem::Template& b,
                     const std::vector<dem::NewParticle>& pair) {
  constexpr double step = 1e-5 * r;  // m; its square and the rounding of U / step are below 1e-6
  const Wrenches found = wrenches_of(a, b, pair);
  EXPECT_GT(found.energy, 0);
  double off = 0;
  for (std::size_t n = 0; n < 2; ++n)
    for (int axis = 0; axis < 6; ++axis) {
      double energy[2];
      for (int side = 0; side < 2; ++side) {
        auto moved = pair;
        const Vec3 by = (side ? step : -step) * Vec3::Unit(axis % 3);
        if (axis < 3)
          moved[n].position += by;
        else
          moved[n].attitude =
              Quat(Eigen::AngleAxisd((side ? step : -step) / size, Vec3::Unit(axis % 3))) *
              moved[n].attitude;
        energy[side] = wrenches_of(a, b, moved).energy;
      }
      const double slope = (energy[0] - energy[1]) / (2 * step);
      const double own = axis < 3 ? found.force[n][axis] : found.torque[n][axis - 3] / size;
      off = std::max(off, std::abs(own - slope) / found.force[0].norm());
    }
  return off;
}

TEST(StonePair, TheForceIsTheGradientOfTheEnergy) {
  for (std::uint64_t key = 0; key < 120; ++key) {
    const dem::Template a = shape(key), b = shape(key + 1 + key / 8);
    EXPECT_LT(off_the_slope(a, b, overlapping(a, b, key)), 1e-6) << key;
  }
}

TEST(StonePair, TheForceIsTheGradientOfTheEnergyWhereCoresOverlap) {
  for (std::uint64_t key = 0; key < 20; ++key) {
    const dem::Template a = shape(key), b = shape(key + 1);
    auto pair = overlapping(a, b, key);
    for (const double depth : {0.75, 0.5}) {
      pair[1].position *= depth;
      EXPECT_LT(off_the_slope(a, b, pair), 1e-6) << key << " " << depth;
    }
  }
}

// Largest jump of the force between `count` poses on a path through many features. Where the cores
// touch only the energy is continuous (`CoresPassIntoEachOther...`): those poses are left out.
double largest_jump(const dem::Template& a, const dem::Template& b, std::uint64_t key, int count) {
  const auto begin = overlapping(a, b, key);
  const Vec3 along = draw(60, key).normalized(), about = draw(70, key).normalized();
  const Vec3 n = begin[1].position.normalized();
  const Vec3 side = (along - along.dot(n) * n).normalized();
  double jump = 0;
  Wrenches last = wrenches_of(a, b, begin);
  bool apart = true;
  for (int s = 1; s <= count; ++s) {
    const double t = static_cast<double>(s) / count;
    auto pair = begin;
    pair[1].position += 2 * r * t * side;
    pair[1].attitude = Quat(Eigen::AngleAxisd(0.1 * t, about)) * pair[1].attitude;
    const bool apart_before = apart;
    apart = test::gap_of(a, pair[0], b, pair[1]) > -1.99 * r;
    const Wrenches found = wrenches_of(a, b, pair);
    if (apart && apart_before)
      jump = std::max({jump, (found.force[0] - last.force[0]).norm(),
                       (found.torque[0] - last.torque[0]).norm() / size});
    last = found;
  }
  return jump;
}

TEST(StonePair, TheForceIsContinuousAlongPaths) {
  for (std::uint64_t key = 0; key < 24; ++key) {
    const dem::Template a = shape(key), b = shape(key + 3);
    const double coarse = largest_jump(a, b, key, 50), fine = largest_jump(a, b, key, 200);
    EXPECT_LT(fine, 0.35 * coarse) << key;  // a quarter, and peaks that the coarse steps missed
    // A step of the path is 2 r / 50; the stiffest direction has p - 1 + n^(2/p) springs.
    EXPECT_LT(coarse, 8 * k * (2 * r + 0.1 * size) / 50) << key;
  }
}

TEST(StonePair, TheForceIsContinuousWhereEdgesBecomeParallel) {
  // Two boxes with all edges parallel, one tilted in both directions about each axis.
  const dem::Template box = test::cuboid({0.5, 0.4, 0.3}), bar = test::cuboid({0.7, 0.35, 0.3});
  for (const dem::Template* other : {&box, &bar})
    for (int axis = 0; axis < 3; ++axis) {
      const auto largest = [&](int count) {
        double jump = 0;
        Vec3 last;
        for (int s = 0; s <= count; ++s) {
          const double angle = 4e-4 * (2.0 * s / count - 1);
          const Quat tilt(Eigen::AngleAxisd(angle, Vec3::Unit(axis)));
          const auto pair = pair_at({0, 0, 0.6 * size - 0.05 * r}, Quat::Identity(), tilt);
          const Vec3 torque = wrenches_of(box, *other, pair).torque[1];
          if (s > 0) jump = std::max(jump, (torque - last).norm());
          last = torque;
        }
        return jump;
      };
      EXPECT_LT(largest(400), 0.35 * largest(100)) << axis;
    }
}

TEST(StonePair, MomentumAndAngularMomentumAreKept) {
  for (const double friction : {0.0, 0.6})
    for (std::uint64_t key = 0; key < 12; ++key) {
      const dem::Template a = shape(key), b = shape(key + 2);
      auto pair = overlapping(a, b, key);
      pair[1].position += 1.5 * r * pair[1].position.normalized();
      pair[1].velocity = -pair[1].position.normalized() + draw(80, key);
      pair[0].spin = 100 * draw(90, key), pair[1].spin = 100 * draw(95, key);
      dem::Particles p = two(a, b, pair, elastic(friction));
      const auto momenta = [&] {
        Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();
        for (std::size_t n = 0; n < 2; ++n) {
          const dem::ParticleView v = p[n];
          const Vec3 gyration = (v.shape ? b : a).gyration * v.scale * v.scale;
          const Vec3 spin = v.attitude.conjugate() * v.spin;
          momentum += v.mass * v.velocity;
          angular += v.mass * (v.position.cross(v.velocity) +
                               v.attitude * Vec3(gyration.cwiseProduct(spin)));
        }
        return std::pair(momentum, angular);
      };
      const auto before = momenta();
      const double dt = 0.1 * std::sqrt(p[0].mass / k);
      bool met = false;
      for (int s = 0; s < 200; ++s) p.advance(10 * dt, 10), met |= p.totals().contacts > 0;
      const auto after = momenta();
      EXPECT_TRUE(met);
      constexpr double rounding = 1e-12;
      EXPECT_LT((after.first - before.first).norm(), rounding * p[1].mass);
      EXPECT_LT((after.second - before.second).norm(), rounding * p[1].mass * size);
    }
}

TEST(StonePair, HowAFaceIsGivenDoesNotMatter) {
  // A box from its corners; the same with points on faces and edges; the same as twelve triangles.
  const Vec3 half = Vec3(0.45, 0.35, 0.25);
  const geom::Convex plain = test::cuboid_core(half);
  std::vector<Vec3> points = plain.vertices;
  for (std::uint64_t key = 0; key < 40; ++key) {
    Vec3 p = 2 * draw(100, key).cwiseProduct(half);
    p[static_cast<int>(key % 3)] = (key % 2 ? 1 : -1) * half[static_cast<int>(key % 3)];
    if (key % 5 == 0) p[static_cast<int>((key + 1) % 3)] = half[static_cast<int>((key + 1) % 3)];
    points.push_back(p);
  }
  std::vector<std::vector<int>> triangles;
  for (const geom::Face& f : plain.faces) {
    ASSERT_EQ(f.vertices.size(), 4u);
    triangles.push_back({f.vertices[0], f.vertices[1], f.vertices[2]});
    triangles.push_back({f.vertices[0], f.vertices[2], f.vertices[3]});
  }
  const auto box_of = [](const geom::Convex& core) {
    return test::solid_of({{core, test::rounding}});
  };
  dem::Template box = box_of(plain), more = box_of(geom::convex_hull(points)), cut = box;
  more.gyration = box.gyration;
  cut.pieces[0].core = geom::convex_of(plain.vertices, triangles);
  for (std::uint64_t key = 0; key < 40; ++key) {
    const dem::Template other = key % 2 ? test::stone(key) : box;
    const auto pair = overlapping(box, other, 3 * key);
    const Wrenches wanted = wrenches_of(box, other, pair);
    ASSERT_GT(wanted.energy, 0);
    for (const dem::Template* same : {&more, &cut}) {
      const Wrenches found = wrenches_of(*same, other, pair);
      EXPECT_NEAR(found.energy, wanted.energy, 1e-9 * wanted.energy) << key << (same == &cut);
      EXPECT_LT((found.force[0] - wanted.force[0]).norm(), 1e-9 * wanted.force[0].norm()) << key;
      EXPECT_LT((found.torque[1] - wanted.torque[1]).norm(), 1e-9 * size * wanted.force[0].norm());
    }
  }
}

TEST(StonePair, DeepPenetrationReturnsTheStoredEnergy) {
  // The rest is the integrator's error: where one direction of separation replaces another the
  // force changes fast. The error falls with the step (a quarter of it: mean 2e-3, largest 1e-2 of
  // 60).
  constexpr double mean_bound = 0.02, bound = 0.06;  // of the energy stored
  double mean = 0;
  constexpr int cases = 24;
  for (std::uint64_t key = 0; key < cases; ++key) {
    const dem::Template a = shape(key), b = shape(key + 1);
    auto pair = overlapping(a, b, key);
    pair[1].position *= 0.6;  // deeply overlapping cores
    const Wrenches found = wrenches_of(a, b, pair);
    dem::Particles p = two(a, b, pair, elastic());
    const double dt = 0.02 * std::sqrt(p[0].mass / k);
    double most = 0;
    for (int s = 0; s < 4000 && (s < 10 || p.totals().contacts > 0); ++s) {
      p.advance(10 * dt, 10);
      most = std::max(most, p.totals().kinetic);
    }
    EXPECT_EQ(p.totals().contacts, 0) << key;
    EXPECT_GT(p.core_overlaps(), 10) << key;       // counted in each sub-step
    EXPECT_GT(found.energy, 0.5 * k * 9 * r * r);  // deeper than the roundings reach, 2 r
    EXPECT_LT(most, (1 + bound) * found.energy) << key;
    EXPECT_GT(p.totals().kinetic, (1 - bound) * found.energy) << key;
    mean += std::abs(p.totals().kinetic / found.energy - 1) / cases;
  }
  EXPECT_LT(mean, mean_bound);
}

// Initially separate: the approach of the cores must be detected during the motion, with features
// found before.
TEST(StonePair, CollidingCoresSeparateAgain) {
  constexpr double bound = 0.01;  // of the energy; 4e-3 at this step, 5e-4 at a tenth of it
  constexpr int cases = 12;
  int deep = 0;
  for (std::uint64_t key = 0; key < cases; ++key) {
    const dem::Template a = shape(key), b = shape(key + 1);
    auto pair = overlapping(a, b, key);
    const Vec3 apart = pair[1].position.normalized();
    pair[1].position += 2 * r * apart;
    dem::Particles still = two(a, b, pair, elastic());
    const double m = still[0].mass * still[1].mass / (still[0].mass + still[1].mass);
    pair[1].velocity = -4 * r * std::sqrt(k / m) * apart;  // stops at an overlap of 4 r or more
    dem::Particles p = two(a, b, pair, elastic());
    const double dt = 0.02 * std::sqrt(m / k), before = p.totals().kinetic;
    bool touched = false;
    for (int s = 0; s < 4000 && !(touched && p.totals().contacts == 0); ++s) {
      p.advance(10 * dt, 10);
      touched = touched || p.totals().contacts > 0;
    }
    EXPECT_TRUE(touched && p.totals().contacts == 0) << key;
    deep += p.core_overlaps() > 10;
    EXPECT_NEAR(p.totals().kinetic / before, 1, bound) << key;
  }
  EXPECT_GE(deep, cases / 2);  // others collide off-centre and turn away
}

// A prism over a regular polygon.
dem::Template prism(int corners) {
  std::vector<Vec3> points;
  for (int c = 0; c < corners; ++c) {
    const double angle = 2 * std::numbers::pi * c / corners;
    for (const double z : {-0.3, 0.3})
      points.emplace_back(0.5 * std::cos(angle), 0.5 * std::sin(angle), z);
  }
  return geom::template_of({{geom::convex_hull(points), test::rounding}});
}

TEST(StonePair, FacesOfManyCornersLoseNone) {
  // Each corner of one against all triangles of the other's face: about 20 * 20 features, more than
  // fit into a byte. A lost one would take its energy with it.
  const dem::Template a = prism(20);
  auto pair = pair_at((0.6 * size + 2 * r) * Vec3::UnitZ(), Quat::Identity(),
                      Quat(Eigen::AngleAxisd(0.1, Vec3::UnitZ())));
  constexpr int count = 60;
  const double step = 1.8 * r / count;
  double work = 0, energy = 0, before = 0;
  for (int s = 1; s <= count; ++s) {
    pair[1].position.z() -= step;
    const Wrenches found = wrenches_of(a, a, pair);
    work += 0.5 * step * (before + found.force[1].z());
    before = found.force[1].z(), energy = found.energy;
  }
  // The trapezoid rule is exact for a linear spring, as for faces that stay parallel.
  EXPECT_NEAR(energy / work, 1, 1e-3);
}

TEST(StonePair, CoresPassIntoEachOtherWithoutAJumpOfEnergy) {
  constexpr double step = 1e-4 * r;  // m; by itself it changes the energy by less than `wanted`
  constexpr double wanted = 0.01;    // of the energy; core overlap is treated from 1e-3 reach apart
  for (std::uint64_t key = 0; key < 48; ++key) {
    const dem::Template a = shape(key), b = shape(key + 1);
    auto pair = overlapping(a, b, key);
    const Vec3 along = pair[1].position.normalized();
    double apart = pair[1].position.norm(), in = 0.2 * apart;
    while (apart - in > 1e-3 * step) {
      pair[1].position = 0.5 * (apart + in) * along;
      (test::gap_of(a, pair[0], b, pair[1]) > -2 * r ? apart : in) = 0.5 * (apart + in);
    }
    double energy[2];
    for (int side = 0; side < 2; ++side) {
      pair[1].position = (apart + (side ? -step : step)) * along;
      energy[side] = wrenches_of(a, b, pair).energy;
    }
    EXPECT_NEAR(energy[1] / energy[0], 1, wanted) << key;
  }
}

// One of nine stones, so that others follow it in its lane and in other lanes.
TEST(StonePair, ValuesThatAreNotNumbersEndTheRun) {
  const dem::Template a = prism(4);
  std::vector<dem::NewParticle> row(9);
  for (std::size_t n = 0; n < row.size(); ++n) {
    row[n].id = static_cast<Id>(n), row[n].scale = 0.01;
    row[n].position.x() = -0.8 + 0.2 * static_cast<double>(n);
  }
  row[2].velocity.x() = std::numeric_limits<double>::quiet_NaN();
  dem::Particles p = two(a, a, row, elastic());
  p.advance(1e-5, 2);
  EXPECT_EQ(p.trouble(),
            "the position or attitude of particle 2 is not a number; use a smaller time.step or "
            "dem.safety");
}

}  // namespace
}  // namespace trackbed::stones_test
