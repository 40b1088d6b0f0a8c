// Study: iterations and seconds of the static solve of a layered ground against its size, for
// suitable solvers. Prints rows for the table in docs/decisions/ground_elements.md; to be run on 1,
// 2 and 4 ranks. Fails if iterations grow with the number of elements along an edge, as then the
// multigrid is ineffective.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <petscsys.h>

#include <chrono>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "trackbed/fem/petsc.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem::solver_scaling_test {
namespace {

using par::Comm;

// Iterations of one static solve of a cube of three layers, `elements` along each edge.
double iterations(std::int64_t elements, const std::string& preconditioner) {
  Petsc::ensure();
  PetscOptionsClear(nullptr);
  if (!preconditioner.empty())
    PetscOptionsSetValue(nullptr, "-ground_pc_type", preconditioner.c_str());
  GroundParameters p = box({10, 10, 10}, {elements, elements, elements}, {});
  p.layers = {{"surface", 0.6, {500e6, 0.33, 1950}},
              {"bottom", 2.4, {200e6, 0.35, 1900}},
              {"subgrade", 7, {150e6, 0.35, 1850}}};
  p.base = Base::fixed;
  p.integrator = Integrator::newmark;  // one long window from rest: K u = F
  const Comm comm = Comm::world();
  Ground ground(comm, p, Dimension::space, 1.0);
  auto load = pressure(ground, 1e5);
  for (std::size_t n = 0; n < load.size() / 3; ++n) load[n] *= 3;
  const auto begin = std::chrono::steady_clock::now();
  ground.advance(1e3, load);
  const double seconds =
      comm.max(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  const GroundTotals totals = ground.totals();
  PetscOptionsClear(nullptr);
  if (comm.root())
    fmt::print("| {} | {} | {} | {:g} | {:.1f} |\n", preconditioner, totals.unknowns, comm.size(),
               totals.iterations_mean, seconds);
  return totals.iterations_mean;
}

class Scaling : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(, Scaling, ::testing::Values("hypre", "gamg"));

TEST_P(Scaling, IterationsHardlyGrow) {
  const double small = iterations(14, GetParam());
  iterations(29, GetParam());
  EXPECT_LT(iterations(46, GetParam()), 46.0 / 14 * small);
  // A million unknowns, where that takes less than a minute.
  if (std::string(GetParam()) == "gamg") {
    EXPECT_LT(iterations(69, GetParam()), 69.0 / 14 * small);
  }
}

}  // namespace
}  // namespace trackbed::fem::solver_scaling_test
