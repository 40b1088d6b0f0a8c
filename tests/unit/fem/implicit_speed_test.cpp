// Study: iterations and milliseconds of an implicit step against its length, for suitable
// preconditioners, in a ground of 35000 hexahedra and one of 30000 plane elements. Prints rows for
// the table in docs/decisions/ground_elements.md; to be run on 1 and 2 ranks. Fails if the default
// is far from the best.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <petscsys.h>

#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "trackbed/core/error.hpp"
#include "trackbed/fem/petsc.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem::implicit_speed_test {
namespace {

using par::Comm;

// 0.25 m elements below 10 m of track, layers of a railway line; the load of a bogie passing at 50
// m/s.
GroundParameters line(Dimension dimension) {
  const bool flat = dimension == Dimension::plane;
  GroundParameters p =
      flat ? box({30, 1, 10}, {300, 1, 100}, {}) : box({10, 7.5, 7.25}, {40, 30, 29}, {});
  p.layers = {{"surface", 0.7, {500e6, 0.33, 1950}},
              {"bottom", 2.3, {200e6, 0.35, 1900}},
              {"subgrade", flat ? 7 : 4.25, {150e6, 0.35, 1850}}};
  p.sides = Sides::viscous;
  p.rayleigh_stiffness = 1e-4;
  p.integrator = Integrator::bossak;
  p.alpha = -0.1;
  return p;
}

// Seconds of a step: the shortest of 20 after the first (setup), as the machine is shared.
double seconds(Dimension dimension, double dt, const std::string& preconditioner) {
  const Comm comm = Comm::world();
  Petsc::ensure();
  PetscOptionsClear(nullptr);
  if (!preconditioner.empty())
    PetscOptionsSetValue(nullptr, "-ground_pc_type", preconditioner.c_str());
  Ground ground(comm, line(dimension), dimension, 1.0);
  const auto unit = pressure(ground, 1e5);
  const auto load = [&](double t) {
    auto force = unit;
    for (std::size_t n = 0; n < force.size(); ++n) {
      const double away = ground.top().position[n].x() - 2 - 50 * t;
      force[n] *= std::exp(-away * away);
    }
    return force;
  };
  const auto begin = std::chrono::steady_clock::now();
  const auto since = [&] {
    return comm.max(
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  };
  ground.settle(load(0));
  const double rest = since();
  const double at_rest = ground.totals().iterations_mean;
  ground.advance(dt, load(dt));
  const double before = since();
  constexpr int steps = 20;
  double inside = 1e9, spent = ground.totals().seconds;
  for (int k = 2; k < 2 + steps; ++k) {
    ground.advance(dt, load(k * dt));
    const double now = ground.totals().seconds;
    inside = std::min(inside, comm.max(now - spent));
    spent = now;
  }
  const GroundTotals totals = ground.totals();
  const double iterations = (totals.iterations_mean * (steps + 2) - at_rest) / (steps + 1);
  PetscOptionsClear(nullptr);
  if (comm.root())
    fmt::print("| {} | {} | {:g} | {} | {} | {:.1f} | {:.1f} | {:.1f} ms |\n", totals.unknowns,
               comm.size(), 1e3 * dt, preconditioner.empty() ? "default" : preconditioner, at_rest,
               rest, iterations, 1e3 * inside);
  std::fflush(stdout);
  EXPECT_GT(before, rest);
  return inside;
}

class Speed : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, Speed, ::testing::Values(Dimension::space, Dimension::plane),
                         dimension_name);

TEST_P(Speed, DefaultIsNearTheBest) {
  std::vector<std::string> choices = {"gamg", "jacobi"};
  if (GetParam() == Dimension::plane) choices.push_back("hypre");  // in space far from the best
  for (const double dt : {5e-4, 2e-3, 1e-2}) {
    double best = 1e9;
    for (const std::string& choice : choices) try {
        best = std::min(best, seconds(GetParam(), dt, choice));
      } catch (const RunError& no_end) {  // the same on all ranks: the static start in a plane
        if (Comm::world().root()) fmt::print("{}: {}\n", choice, no_end.what());
      }
    EXPECT_LT(seconds(GetParam(), dt, ""), 2 * best) << dt;  // timing on a shared machine
  }
}

}  // namespace
}  // namespace trackbed::fem::implicit_speed_test
