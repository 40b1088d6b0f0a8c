// A wave from below a ground of tetrahedra, from a mesh file or of sections: it doubles at the top
// and goes out where it came in.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/verified.hpp"
#include "unit/fem/compared.hpp"
#include "unit/fem/ground_scene.hpp"
#include "unit/fem/mesh_scene.hpp"
#include "unit/fem/wave.hpp"

namespace trackbed::fem {
namespace {

using par::Comm;
using std::numbers::pi;

constexpr Elastic soil{50e6, 0.3, 2000};

// 20 m of tetrahedra between rollers.
GroundParameters column_of_mesh() {
  GroundParameters p = of_mesh(TetBox({1, 1, 20}, {1, 1, 20}), "wave_column", soil);
  p.borders[4].holds = BorderKind::quiet;
  EXPECT_TRUE(look_at_mesh(p).warnings.empty());
  return p;
}
GroundParameters column_of_sections() {
  GroundParameters p = box({1, 1, 20}, {1, 1, 20}, soil);
  p.y = {-0.5, 0.5};
  p.layers = {{.name = "raised", .thickness = 5, .solid = soil, .zones = 5},
              {.name = "natural", .thickness = 15, .solid = soil, .zones = 15}};
  p.sections = {{.x = 0, .crest = 0.5, .slope = 0}};
  p.embankment_layers = 1;
  return p;
}

// A wave of pressure upwards through the quiet bottom.
void check_wave(const std::string& ground_of, const GroundParameters& column) {
  const Comm comm = Comm::world();
  constexpr Ricker wave{5, 0.3};                                                  // Hz, s
  constexpr double standard = 9.81;                                               // m/s^2
  const double speed = std::sqrt(soil.young * 0.7 / (1.3 * 0.4) / soil.density);  // m/s
  for (const auto& [name, integrator] :
       {std::pair{"explicit", Integrator::explicit_}, {"newmark", Integrator::newmark}}) {
    GroundParameters p = column;
    p.base_stiffness = 0;
    p.integrator = integrator;
    p.base_motion = wave_table(comm, "mesh_column", wave, 0, standard, 1e-3);
    Ground ground(comm, p, Dimension::space, 1);
    ground.settle(none(ground));
    constexpr double dt = 2e-3;
    double most = 0, when = 0, after = 0;
    for (int w = 1; w <= 600; ++w) {
      ground.advance(dt, none(ground));
      double high = -1e300;
      for (const auto n : ground.own_top()) high = std::max(high, ground.top_state(n).velocity.z());
      high = comm.max(high);
      if (high > most) most = high, when = w * dt;
      if (w * dt > 2 * wave.centre + 20 / speed) after = std::max(after, std::abs(high));
    }
    // The velocity is tau exp(-(pi f tau)^2): largest at tau = 1/(sqrt(2) pi f).
    const double tau = 1 / (std::sqrt(2.0) * pi * wave.frequency);
    const double exact = 2 * standard * tau * std::exp(-0.5);
    verified::near(fmt::format("largest velocity of the top, {}, {}", ground_of, name), "m/s", most,
                   exact, 0.02 * exact);
    verified::near(fmt::format("time of it after that at the base, {}, {}", ground_of, name), "s",
                   when - wave.centre - tau, 20 / speed, 0.02 * 20 / speed);
    // It goes out below: nothing comes back.
    verified::below(
        fmt::format("velocity when it has left, over the largest, {}, {}", ground_of, name), "-",
        after / most, 0.02);
  }
}

TEST(MeshedGround, WaveFromBelowDoublesAtTheTop) { check_wave("mesh file", column_of_mesh()); }

TEST(GroundOfSections, WaveFromBelowDoublesAtTheTop) {
  check_wave("sections", column_of_sections());
}

}  // namespace
}  // namespace trackbed::fem
