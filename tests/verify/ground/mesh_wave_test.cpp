// A wave from below a ground of tetrahedra, from a mesh file or of sections: it doubles at the top
// and leaves through the base; a ground without tensile strength is launched upwards as one of
// boxes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "support/verified.hpp"
#include "unit/fem/compared.hpp"
#include "unit/fem/ground_scene.hpp"
#include "unit/fem/mesh_scene.hpp"
#include "unit/fem/wave.hpp"

namespace trackbed::fem::mesh_wave_test {
namespace {

using par::Comm;
using std::numbers::pi;

constexpr Elastic soil{50e6, 0.3, 2000};

// 20 m of tetrahedra between rollers.
GroundParameters column_of_mesh() {
  GroundParameters p = of_mesh(TetBox({1, 1, 20}, {1, 1, 20}), "wave_column", soil);
  p.borders[4].holds = BorderKind::viscous;
  EXPECT_TRUE(look_at_mesh(p).warnings.empty());
  return p;
}
GroundParameters column_of_sections() {
  GroundParameters p = box({1, 1, 20}, {1, 1, 20}, soil);
  p.y = {-0.5, 0.5};
  p.layers = {{.name = "raised", .thickness = 5, .solid = soil, .elements = 5},
              {.name = "natural", .thickness = 15, .solid = soil, .elements = 15}};
  p.sections = {{.x = 0, .crest = 0.5, .slope = 0}};
  p.embankment_layers = 1;
  return p;
}

// A wave of pressure upwards through the viscous bottom.
void check_wave(const std::string& ground_of, const GroundParameters& column) {
  const Comm comm = Comm::world();
  constexpr Ricker wave{5, 0.3};                                                  // Hz, s
  constexpr double standard = 9.81;                                               // m/s^2
  const double speed = std::sqrt(soil.young * 0.7 / (1.3 * 0.4) / soil.density);  // m/s
  for (const auto& [name, integrator] :
       {std::pair{"explicit", Integrator::explicit_}, {"newmark", Integrator::newmark}}) {
    GroundParameters p = column;
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
    // Edges of h = 1 m, omega h / c = 0.17 at 5 Hz, twice that at the end of the spectrum.
    const verified::Tolerance mesh{0.015, "base and top: (omega h / c)^2 / 8 = 1.5 % at 10 Hz"};
    verified::near(fmt::format("largest velocity of the top, {}, {}", ground_of, name), "m/s", most,
                   exact, mesh.of(exact));
    verified::near(fmt::format("time of it after that at the base, {}, {}", ground_of, name), "s",
                   when - wave.centre - tau, 20 / speed, {dt, "sampled every 2 ms"});
    verified::below(
        fmt::format("velocity when it has left, over the largest, {}, {}", ground_of, name), "-",
        after / most,
        {1e-3, "base reflects (omega h / c)^2 / 16 = 2e-3, a fifth of it after this"});
  }
}

GroundParameters column_of_layers() {
  GroundParameters p = box({1, 1, 20}, {1, 1, 20}, soil);
  p.sides = Sides::roller;
  p.base = Base::viscous;
  return p;
}

// A wave with a displacement of 5 mm in a fifth of a second.
struct Lift {
  static constexpr double displacement = 5e-3, time = 0.2, dt = 2e-3;  // m, s, s
  static constexpr int windows = 400;
  static double velocity(double t) {  // m/s, a triangle
    return std::max(0.0, 2 * displacement / time * (1 - std::abs(2 * t / time - 1)));
  }
};

// Displacement of the top after each window, m.
std::vector<double> lifted(GroundParameters p, Integrator integrator) {
  const Comm comm = Comm::world();
  const std::string table = fmt::format("lifted_on_{}.csv", comm.size());
  comm.sum(std::int64_t{1});  // no rank still reads an older file of this name
  if (comm.root())
    std::ofstream(table) << fmt::format("time_s,vx_m_s,vz_m_s\n0,0,0\n{},0,{}\n{},0,0\n",
                                        Lift::time / 2, Lift::velocity(Lift::time / 2), Lift::time);
  comm.sum(std::int64_t{1});  // no rank reads before the file is written
  p.integrator = integrator;
  p.base_motion = table;
  Ground ground(comm, p, Dimension::space, 1);
  ground.settle(none(ground));
  std::vector<double> top;
  for (int w = 0; w < Lift::windows; ++w) {
    ground.advance(Lift::dt, none(ground));
    double high = -1e300;
    for (const auto n : ground.own_top())
      high = std::max(high, ground.top_state(n).displacement.z());
    top.push_back(comm.max(high));
  }
  return top;
}

// The top moves by twice the displacement of the wave, H/c_p later, without a restoring force.
TEST(MeshedGround, IsLiftedTwiceAsFarAsItsWave) {
  const double speed = std::sqrt(soil.young * 0.7 / (1.3 * 0.4) / soil.density);
  std::vector<double> exact;
  double below = 0;
  constexpr int fine = 200;  // steps of a window
  for (int s = 0; s < fine * Lift::windows; ++s) {
    const double h = Lift::dt / fine;
    below += h * Lift::velocity((s + 0.5) * h - 20 / speed);
    if ((s + 1) % fine == 0) exact.push_back(2 * below);
  }
  const std::vector<std::pair<std::string, GroundParameters>> columns = {
      {"mesh file", column_of_mesh()},
      {"sections", column_of_sections()},
      {"layers", column_of_layers()}};
  for (const auto& [integrator, name] :
       {std::pair{Integrator::explicit_, "explicit"}, {Integrator::newmark, "newmark"}})
    for (const auto& [ground_of, column] : columns) {
      const std::vector<double> top = lifted(column, integrator);
      double off = 0;
      for (std::size_t w = 0; w < top.size(); ++w) off = std::max(off, std::abs(top[w] - exact[w]));
      verified::below(fmt::format("error of a lift over its displacement, {}, {}", ground_of, name),
                      "-", off / Lift::displacement,
                      {0.01, "corners of the velocity: 1 m/s^2 (h / c)^2 = 0.6 % of 5 mm"});
    }
}

// A wave of 10 Hz and 0.1 m/s below 20 m without tensile strength, in elements of half a metre.
struct Launch {
  double most, end;  // m
};
Launch launch(GroundParameters p, Integrator integrator) {
  const Comm comm = Comm::world();
  const std::string table = fmt::format("launched_on_{}.csv", comm.size());
  comm.sum(std::int64_t{1});  // no rank still reads an older file of this name
  if (comm.root()) {
    std::ofstream file(table);
    file << "time_s,vx_m_s,vz_m_s\n";
    for (int r = 0; r <= 200; ++r)
      file << fmt::format("{},0,{}\n", r * 1e-3, r >= 100 ? 0 : 0.1 * std::sin(pi * r / 50));
  }
  comm.sum(std::int64_t{1});  // no rank reads before the file is written
  p.integrator = integrator;
  p.base_motion = table;
  const Strength loose{Yield::mohr_coulomb, 50e3, 30, 0, 0};
  for (Layer& layer : p.layers) layer.strength = loose;
  for (MeshSolid& solid : p.solids) solid.strength = loose;
  Ground ground(comm, p, Dimension::space, 1);
  ground.settle(none(ground));
  double most = 0, high = 0;
  for (int w = 0; w < 900; ++w) {
    ground.advance(1e-3, none(ground));
    high = -1e300;
    for (const auto n : ground.own_top())
      high = std::max(high, ground.top_state(n).displacement.z());
    most = std::max(most, high);
  }
  EXPECT_EQ(ground.trouble(), "");
  return {comm.max(most), comm.max(high)};
}

TEST(MeshedGround, WithoutTensileStrengthIsLaunchedAsBoxes) {
  GroundParameters file = of_mesh(TetBox({1, 1, 20}, {1, 1, 40}), "loose_column", soil);
  file.borders[4].holds = BorderKind::viscous;
  GroundParameters boxes = box({1, 1, 20}, {1, 1, 40}, soil);
  boxes.sides = Sides::roller;
  boxes.base = Base::viscous;
  const Launch exact = launch(boxes, Integrator::explicit_);
  EXPECT_GT(exact.most, 5e-3);
  for (const Integrator integrator : {Integrator::explicit_, Integrator::newmark}) {
    const Launch found = launch(file, integrator);
    EXPECT_NEAR(found.most, exact.most, 0.03 * exact.most);
    EXPECT_NEAR(found.end, exact.end, 0.06 * exact.most);
  }
}

TEST(MeshedGround, WaveFromBelowDoublesAtTheTop) { check_wave("mesh file", column_of_mesh()); }

TEST(GroundOfSections, WaveFromBelowDoublesAtTheTop) {
  check_wave("sections", column_of_sections());
}

}  // namespace
}  // namespace trackbed::fem::mesh_wave_test
