// Pairs of pieces other than polyhedra: balls, capsules, plates, and flat cores in a plane model.
#include <gtest/gtest.h>

#include "support/stone_pairs.hpp"

namespace trackbed::stones_shapes_test {
namespace {

constexpr double k = 1e6;   // N/m
constexpr double r = 0.05;  // m, of every rounding here

dem::Template shape_of(const geom::Convex& core) {
  dem::Template t;
  t.pieces = {{core, r}};
  t.volume = 1;
  t.gyration = Vec3::Constant(0.1);
  return t;
}

dem::Template capsule(double half) {
  return shape_of(geom::convex_hull({{-half, 0, 0}, {half, 0, 0}}));
}

dem::Template ball() { return shape_of(geom::ball(Vec3::Zero(), r).core); }

dem::Particles two(const dem::Template& a, const dem::Template& b, const Vec3& second,
                   const Quat& turn = Quat::Identity(), Dimension dimension = Dimension::space) {
  dem::ContactLaw law;
  law.k_n = k, law.k_s = 0, law.friction = 0;
  dem::Parameters parameters;
  parameters.gravity = 0, parameters.largest_overlap = 1e3;
  dem::Domain domain = test::box(Vec3::Constant(-20), Vec3::Constant(20));
  domain.dimension = dimension;
  dem::Particles p(par::Comm::self(), test::one_material(law), parameters, domain);
  p.add_template(a), p.add_template(b);
  std::vector<dem::NewParticle> pair(2);
  pair[1].id = pair[1].shape = 1;
  pair[1].position = second, pair[1].attitude = turn;
  p.add(pair);
  p.advance(1e-30, 1);
  return p;
}

void expect_near(const Vec3& a, const Vec3& b, double wanted) {
  EXPECT_LT((a - b).norm(), wanted) << a.transpose() << " is not " << b.transpose();
}

constexpr double delta = 0.01 * r, rounding = 1e-9 * k * delta;

TEST(StoneShapes, TheForceOnABallAtFaceEdgeAndCornerFollowsTheDistance) {
  const Vec3 half(0.5, 0.4, 0.3);
  const dem::Template box = shape_of(test::cuboid_core(half));
  // On a face at the diagonal between its triangles and beside it, on an edge, at a corner.
  const Vec3 feet[] = {{0, 0, 0.3}, {0.1, 0.08, 0.3}, {-0.3, 0.2, 0.3}, {0.2, 0.4, 0.3}, half};
  const Vec3 normals[] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0.6, 0.8}, {0.48, 0.6, 0.64}};
  for (std::size_t n = 0; n < 5; ++n) {
    const Vec3 at = feet[n] + (2 * r - delta) * normals[n];
    const dem::Particles p = two(box, ball(), at);
    expect_near(p[1].force, k * delta * normals[n], rounding);
    expect_near(p[1].torque, Vec3::Zero(), rounding);
    EXPECT_NEAR(p.totals().elastic, 0.5 * k * delta * delta, rounding * delta);
  }
}

TEST(StoneShapes, CrossedCapsulesTouchOnce) {
  const Quat turn(Eigen::AngleAxisd(0.7, Vec3::UnitZ()));
  const dem::Particles p = two(capsule(0.5), capsule(0.5), {0.1, 0.05, 2 * r - delta}, turn);
  // Off the middle of both the distance is slightly larger: `centring`^2 / 4 of the reach at most.
  constexpr double off = 0.25e-4 * 2 * r;
  EXPECT_LT(p[1].force.z(), k * delta + rounding);
  EXPECT_GT(p[1].force.z(), k * (delta - off));
}

TEST(StoneShapes, EqualFeaturesShareTheLoad) {
  // Capsules side by side: four ends and one pair of edges with the same overlap. M = 5^(1/6) delta
  // and the force U'(M) dM/d delta is 5^(1/3) k delta.
  const dem::Particles p = two(capsule(0.5), capsule(0.5), {0, 0, 2 * r - delta});
  EXPECT_NEAR(p[1].force.z(), std::cbrt(5) * k * delta, rounding);
  expect_near(p[1].torque, Vec3::Zero(), rounding);
  EXPECT_NEAR(p.totals().elastic, 0.5 * std::cbrt(5) * k * delta * delta, rounding * delta);
}

// Triangles and bars in the plane y = 0.
dem::Template plate() {
  return shape_of(geom::convex_hull({{-0.5, 0, -0.3}, {0.5, 0, -0.3}, {0, 0, 0.6}}));
}

TEST(StoneShapes, FlatCoresStayInTheirPlane) {
  for (int n = 0; n < 40; ++n) {
    const Quat turn(Eigen::AngleAxisd(0.157 * n, Vec3::UnitY()));
    for (const dem::Template& other : {plate(), capsule(0.4), ball()}) {
      const double depth = n % 2 ? 0.1 : 0.55;  // the latter: overlapping cores
      const Vec3 at = (n % 3 ? 1 : -1) * Vec3(0.1, 0, 0.3 + r - depth * r - (depth > 0.5 ? r : 0));
      dem::Particles p = two(plate(), other, at, turn, Dimension::plane);
      for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_EQ(p[i].force.y(), 0);
        EXPECT_EQ(p[i].torque.x(), 0);
        EXPECT_EQ(p[i].torque.z(), 0);
      }
      const double stored = p.totals().elastic;
      EXPECT_GT(stored, 0);
      const double dt = 0.02 * std::sqrt(std::min(p[0].mass, p[1].mass) / k);
      for (int s = 0; s < 400 && p.totals().contacts > 0; ++s) p.advance(50 * dt, 50);
      EXPECT_EQ(p.totals().contacts, 0) << n;
      EXPECT_NEAR(p.totals().kinetic, stored, 0.4 * stored) << n;  // deep: as in space
      EXPECT_EQ(p[1].position.y(), 0);
    }
  }
}

TEST(StoneShapes, TheForceOnFlatCoresIsTheGradient) {
  constexpr double step = 1e-6 * r;
  for (int n = 0; n < 60; ++n) {
    const double angle = 0.105 * n;
    const auto turned = [](double a) { return Quat(Eigen::AngleAxisd(a, Vec3::UnitY())); };
    dem::NewParticle lower, upper;
    upper.position = Vec3(0.05 * (n % 5), 0, 2);
    upper.attitude = turned(angle);
    test::bring_near(plate(), lower, plate(), upper, 0.01 * r, -Vec3::UnitZ());
    const Vec3 at = upper.position - Vec3(0, 0, 0.5 * r);
    const auto energy = [&](double dx, double dz, double da) {
      return two(plate(), plate(), at + Vec3(dx, 0, dz), turned(angle + da), Dimension::plane)
          .totals()
          .elastic;
    };
    const dem::Particles p = two(plate(), plate(), at, turned(angle), Dimension::plane);
    const Vec3 slope(energy(step, 0, 0) - energy(-step, 0, 0),
                     energy(0, step, 0) - energy(0, -step, 0),
                     energy(0, 0, step) - energy(0, 0, -step));
    const Vec3 found(p[1].force.x(), p[1].force.z(), p[1].torque.y());
    expect_near(found, -slope / (2 * step), 1e-5 * found.norm() + 1e-6 * k * r);
  }
}

}  // namespace
}  // namespace trackbed::stones_shapes_test
