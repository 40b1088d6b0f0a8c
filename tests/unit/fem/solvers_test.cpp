// Choice of the linear solver: PETSc options after -- (prefix ground_) take effect, and every
// suitable solver gives the same displacement.
#include <gtest/gtest.h>
#include <petscsys.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "trackbed/core/error.hpp"
#include "trackbed/fem/petsc.hpp"
#include "unit/fem/ground_scene.hpp"

namespace trackbed::fem::solvers_test {
namespace {

using par::Comm;
using Options = std::vector<std::pair<std::string, std::string>>;

// Options for the duration of a test; defaults set by the ground are removed with them.
struct Chosen {
  explicit Chosen(const Options& options) {
    Petsc::ensure();
    PetscOptionsClear(nullptr);
    for (const auto& [name, value] : options)
      PetscOptionsSetValue(nullptr, ("-ground_" + name).c_str(), value.c_str());
  }
  ~Chosen() { PetscOptionsClear(nullptr); }
  Chosen(const Chosen&) = delete;
  Chosen& operator=(const Chosen&) = delete;
};

// Static displacement of the top under a non-uniform load, and the number of iterations.
struct Solved {
  std::vector<double> displacement;
  double iterations;
};
Solved solve(const Options& options, Dimension dimension) {
  const Chosen chosen(options);
  GroundParameters p = box({4, 2, 2}, {16, 8, 8}, {});
  p.layers = {{"top", 0.7, {80e6, 0.35, 1900}}, {"sub", 1.3, {200e6, 0.3, 2000}}};
  p.base = Base::fixed;
  p.integrator = Integrator::newmark;
  p.tolerance = 1e-10;
  const Comm comm = Comm::world();
  Ground ground(comm, p, dimension, 1.0);
  auto load = pressure(ground, 1e5);
  for (std::size_t n = 0; n < load.size() / 3; ++n) load[n] *= 3;
  ground.advance(1e3, load);  // one long window from rest: K u = F
  Solved solved{std::vector<double>(ground.top().nodes(), 0.0), ground.totals().iterations_mean};
  for (const auto n : ground.own_top())
    solved.displacement[static_cast<std::size_t>(n)] = ground.top_state(n).displacement.z();
  comm.sum(std::span<double>(solved.displacement));
  return solved;
}

class Solvers : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, Solvers, ::testing::Values(Dimension::plane, Dimension::space),
                         dimension_name);

TEST_P(Solvers, GiveTheSameDisplacement) {
  const Solved expected = solve({{"pc_type", "hypre"}}, GetParam());
  // Elasticity as a system: unknowns by node, rigid motions from the near null space.
  const Options systems = {{"pc_type", "hypre"},
                           {"pc_hypre_type", "boomeramg"},
                           {"pc_hypre_boomeramg_nodal_coarsen", "4"},
                           {"pc_hypre_boomeramg_vec_interp_variant", "2"}};
  const std::vector<std::pair<const char*, Options>> choices = {
      {"gamg", {{"pc_type", "gamg"}}},
      {"boomeramg on nodes", systems},
      {"mumps",
       {{"ksp_type", "preonly"}, {"pc_type", "cholesky"}, {"pc_factor_mat_solver_type", "mumps"}}},
      {"jacobi", {{"pc_type", "jacobi"}}}};
  for (const auto& [name, options] : choices) {
    const Solved solved = solve(options, GetParam());
    double difference = 0, size = 0;
    for (std::size_t n = 0; n < solved.displacement.size(); ++n) {
      difference =
          std::max(difference, std::abs(solved.displacement[n] - expected.displacement[n]));
      size = std::max(size, std::abs(expected.displacement[n]));
    }
    // The tolerance times the condition of a ground of 8 elements' depth, some hundred.
    EXPECT_LT(difference / size, 1e-7) << name;
    // All solvers differ: no two need the same number of iterations.
    EXPECT_NE(solved.iterations, expected.iterations) << name;
    if (std::string(name) == "mumps") {
      EXPECT_EQ(solved.iterations, 1);
    }
  }
}

// The same system is solved in every step; a single solve in a plane has another default.
TEST_P(Solvers, LongStepsTakeGamgByDefault) {
  const Solved chosen = solve({}, GetParam()), gamg = solve({{"pc_type", "gamg"}}, GetParam());
  EXPECT_EQ(chosen.iterations, gamg.iterations);
  EXPECT_EQ(chosen.displacement, gamg.displacement);
}

// For PETSc a single application of any preconditioner counts as converged.
TEST(Solver, ThatSolvesNothingIsRefused) {
  EXPECT_THROW(solve({{"ksp_type", "preonly"}, {"pc_type", "jacobi"}}, Dimension::plane), RunError);
}

}  // namespace
}  // namespace trackbed::fem::solvers_test
