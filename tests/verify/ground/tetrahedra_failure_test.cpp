// Yielding tetrahedra: triaxial strength, a vertical cut in clay.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/kernel/plasticity.hpp"
#include "support/verified.hpp"
#include "trackbed/core/error.hpp"
#include "unit/fem/embankment_scene.hpp"
#include "unit/fem/mesh_scene.hpp"

namespace trackbed::fem::tetrahedra_failure_test {
namespace {

using par::Comm;

GroundParameters sample(const Elastic& solid, const Strength& strength) {
  GroundParameters p = upright({-1, 1});
  p.x = {0, 2}, p.elements_x = 2, p.elements_y = 2;
  for (Layer& layer : p.layers) layer.solid = solid, layer.strength = strength;
  return p;
}

// The same strength of a solid of a mesh file.
GroundParameters sample_of_file(const Elastic& solid, const Strength& strength) {
  GroundParameters p = of_mesh(TetBox({2, 2, 2}, {2, 2, 2}), "triaxial", solid);
  p.solids[0].strength = strength;
  return p;
}

constexpr double last_step = 1e-4 / 3000;  // of axial strain

// Uniform strain along z at constant lateral pressure by elastic corrections; final stress, Pa.
double strength_of(const GroundParameters& parameters, const Elastic& solid, double pressure) {
  const Mesh mesh(Comm::self(), parameters, Dimension::space, 1);
  const Stiffness stiffness(mesh, {});
  Plasticity plasticity(mesh, &stiffness.tetrahedra());
  const Nodal none(3, mesh.nodes());
  Nodal u(none);
  Vec3 strain = Vec3::Zero();
  const auto stress = [&] {
    return Vec6(stiffness.tetrahedra().stress(0, tetrahedron_centre(), u) +
                plasticity.stress(0, Plasticity::Where::centre, Plasticity::When::since));
  };
  const auto go = [&](double axial, int steps) {
    const double from = strain.z();
    for (int k = 1; k <= steps; ++k) {
      const Vec6 now = stress();
      strain.z() = from + (axial - from) * k / steps;
      for (int c = 0; c < 2; ++c) strain[c] -= (now(c) + pressure) / (1.5 * solid.young);
      for (std::size_t n = 0; n < mesh.nodes(); ++n)
        for (int c = 0; c < 3; ++c)
          u[c][n] = strain[c] * mesh.position(static_cast<std::int32_t>(n))[c];
      plasticity.flow(none, u);
    }
  };
  const double begin = -(1 - 2 * solid.poisson) * pressure / solid.young;
  go(begin, 200), go(-0.02, 1500), go(-0.02 - 600 * last_step, 600);
  return -stress()(2);
}

TEST(TetrahedraThatYield, TriaxialStrength) {
  if (Comm::world().size() > 1) return;  // of each rank alone
  for (const auto& [cohesion, friction] : std::array{std::array{20e3, 30.0}, std::array{50e3, 0.0}})
    for (const double pressure : {0.0, 100e3}) {
      const double sine = std::sin(friction * std::numbers::pi / 180);
      const double n = (1 + sine) / (1 - sine);
      const double exact = n * pressure + 2 * cohesion * std::sqrt(n);
      const Elastic solid{50e6, 0.3, 2000};
      const Strength limit{Yield::mohr_coulomb, cohesion, friction, 0, 10e3};
      const std::string name = fmt::format("strength, c {:g} kPa, phi {:g}, at {:g} kPa",
                                           cohesion / 1e3, friction, pressure / 1e3);
      // As in failure_test.cpp; no dilation.
      const verified::Tolerance lag{n * 0.75 * solid.young * last_step * 1.5,
                                    "N 3/4 E times the last step of strain, 1.5 times"};
      verified::near(name, "Pa", strength_of(sample(solid, limit), solid, pressure), exact, lag);
      verified::near(name + ", of a file", "Pa",
                     strength_of(sample_of_file(solid, limit), solid, pressure), exact, lag);
    }
}

// A bank of clay of 2 m with upright sides, a slice between rollers. It fails at the latest where
// gamma H / c exceeds 3.83, by a circle through its foot (Taylor 1937): an upper bound.
bool stands(double number) {
  GroundParameters p = embankment();
  p.x = {0, 0.25}, p.y = {0, 5}, p.elements_x = 1, p.elements_y = 20;
  const double height = 2, density = 2000;
  const Strength clay{Yield::mohr_coulomb, gravity * density * height / number, 0, 0, 1e6};
  p.layers = {{.name = "bank", .thickness = height, .solid = {50e6, 0.3, density}, .elements = 8},
              {.name = "below", .thickness = 1, .solid = {50e6, 0.3, density}, .elements = 4}};
  for (Layer& layer : p.layers) layer.strength = clay;
  p.sections = {{.x = 0, .crest = 3, .slope = 0}};
  p.embankment_layers = 1;
  p.tolerance = 1e-8;
  Ground ground(Comm::world(), p, Dimension::space, 1);
  try {
    ground.settle(std::vector<Vec3>(ground.top().nodes(), Vec3::Zero()));
  } catch (const RunError&) {
    return false;
  }
  return true;
}

TEST(TetrahedraThatYield, CutOfClayHasItsStabilityNumber) {
  double low = 3.4, high = 4.2;
  EXPECT_TRUE(stands(low));
  EXPECT_FALSE(stands(high));
  while (high - low > 0.25) (stands((low + high) / 2) ? low : high) = (low + high) / 2;
  verified::near("stability number of a vertical cut", "-", (low + high) / 2, 3.83,
                 {0.2, "bisection to 0.1, and elements of an eighth of the height: 3 %"});
}

}  // namespace
}  // namespace trackbed::fem::tetrahedra_failure_test
