// Assembly and solution with PETSc. Each rank adds the rows of its own nodes from the elements that
// it holds, so assembly sends no messages.
//
// (Conjugate gradients: Hestenes, Stiefel 1952, doi:10.6028/jres.049.044; BoomerAMG: Henson, Yang
// 2002, doi:10.1016/S0168-9274(01)00115-5.) All calls are collective.
#include "fem/solver/linear_system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "fem/solver/linear_system_handles.hpp"
#include "fem/solver/petsc_check.hpp"
#include "trackbed/fem/petsc.hpp"
#include "trackbed/par/mpi.hpp"

namespace trackbed::fem {

namespace {

constexpr const char* prefix = "ground_";

// Sets an option unless the user did; returns true if it has this value. The options database is
// the interface of PETSc: options of the user after -- take precedence, and a default that depends
// on another one (the settings of hypre) is set only if that one is not overridden.
bool suggest(const std::string& name, const char* value) {
  PetscBool given = PETSC_FALSE;
  std::array<char, 256> word{};
  check(PetscOptionsGetString(nullptr, prefix, ("-" + name).c_str(), word.data(), word.size(),
                              &given),
        "read its options");
  if (given == PETSC_TRUE) return std::string(word.data()) == value;
  check(PetscOptionsSetValue(nullptr, fmt::format("-{}{}", prefix, name).c_str(), value),
        "set an option");
  return true;
}

}  // namespace

// Upper bound of the entries in rows of own nodes. A node of a lattice is coupled to 27 nodes in
// space and 9 in a plane, one of tetrahedra to those of the elements around it.
std::vector<PetscInt> LinearSystem::Handles::entries() const {
  const auto of_each = static_cast<std::size_t>(components);
  std::vector<PetscInt> rows(mesh.own.size() * of_each, components == 3 ? 81 : 18);
  if (!mesh.imported) return rows;
  std::vector<std::vector<std::int32_t>> coupled(mesh.nodes());
  for (const auto& nodes : mesh.imported->corner)
    for (const std::int32_t n : nodes)
      if (mesh.owned[static_cast<std::size_t>(n)] != 0) {
        auto& list = coupled[static_cast<std::size_t>(n)];
        list.insert(list.end(), nodes.begin(), nodes.end());
      }
  for (std::size_t n = 0; n < mesh.own.size(); ++n) {
    auto& list = coupled[static_cast<std::size_t>(mesh.own[n])];
    std::sort(list.begin(), list.end());
    const auto count = std::unique(list.begin(), list.end()) - list.begin();
    std::fill_n(rows.begin() + static_cast<std::ptrdiff_t>(n * of_each), of_each,
                static_cast<PetscInt>(components * count));
  }
  return rows;
}

// Unknowns are numbered by owner, then by node, with the components of a node together (blocks for
// solvers that use them). Ghosts receive their number from the owner.
void LinearSystem::Handles::create() {
  std::vector<std::int64_t> mine(mesh.nodes(), -1);
  for (std::size_t n = 0; n < mesh.own.size(); ++n)
    mine[static_cast<std::size_t>(mesh.own[n])] = mesh.first_own + static_cast<std::int64_t>(n);
  number = mesh.exchange(mine);
  const auto rows = static_cast<PetscInt>(mesh.own.size()) * components;
  const auto all = static_cast<PetscInt>(mesh.comm.sum(static_cast<std::int64_t>(rows)));
  // PETSc rejects more entries in a row than there are columns: own ones, or all.
  std::vector<PetscInt> inner = entries(), outer = inner;
  for (PetscInt& count : inner) count = std::min(count, rows);
  for (PetscInt& count : outer) count = std::min(count, all);
  const MPI_Comm comm = par::mpi(mesh.comm);
  check(MatCreate(comm, matrix.create()), "create a matrix");
  check(MatSetSizes(matrix, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE),
        "set the size of a matrix");
  check(MatSetBlockSize(matrix, components), "set the size of a matrix");
  check(MatSetType(matrix, MATAIJ), "set the type of a matrix");
  check(MatSeqAIJSetPreallocation(matrix, 0, inner.data()), "allocate a matrix");
  check(MatMPIAIJSetPreallocation(matrix, 0, inner.data(), 0, outer.data()), "allocate a matrix");
  check(MatCreateVecs(matrix, solution.create(), right.create()), "create vectors");
  check(VecDuplicate(right, residual.create()), "create a vector");
  check(VecDuplicate(right, correction.create()), "create a vector");
}

// Rows of own nodes are complete here: every element that contains them is held.
void LinearSystem::Handles::add_element(Mat to, std::size_t element, const Eigen::MatrixXd& k,
                                        double factor) {
  const int corners = mesh.corners();
  const auto at_home = [&](int k) { return mesh.home(mesh.corner(element, k)); };
  for (int a = 0; a < corners; ++a) {
    const std::int32_t node = at_home(a);
    if (mesh.owned[static_cast<std::size_t>(node)] == 0) continue;
    for (int c = 0; c < components; ++c) {
      // Rows and columns of fixed unknowns are left out: the matrix remains symmetric.
      if (is_held(node, c)) continue;
      std::array<PetscInt, 30> columns{};
      std::array<PetscScalar, 30> values{};
      PetscInt count = 0;
      for (int b = 0; b < corners; ++b)
        for (int d = 0; d < components; ++d) {
          if (is_held(at_home(b), d)) continue;
          columns[static_cast<std::size_t>(count)] = row(at_home(b), d);
          values[static_cast<std::size_t>(count++)] =
              factor * k(a * components + c, b * components + d);
        }
      const PetscInt at = row(node, c);
      check(MatSetValues(to, 1, &at, count, columns.data(), values.data(), ADD_VALUES),
            "fill a matrix");
    }
  }
}

// Elements in ascending order per row: the matrix is bitwise identical on any number of ranks,
// though the solution is not (dot products).
void LinearSystem::Handles::assemble(const Spec& spec) {
  for (std::size_t z = 0; z < mesh.element.size(); ++z)
    add_element(matrix, z, stiffness.matrix(mesh, z),
                spec.stiffness_factor[static_cast<std::size_t>(mesh.solid[z])]);
  // A fixed unknown has a row of its own, with a stiffness similar to its neighbours for the
  // multigrid.
  for (std::size_t z = 0; z < mesh.element.size() && stiff == 0; ++z)
    stiff = spec.stiffness_factor[static_cast<std::size_t>(mesh.solid[z])] *
            stiffness.matrix(mesh, z)(0, 0);
  for (const std::int32_t node : mesh.own)
    for (int c = 0; c < components; ++c) {
      const PetscInt at = row(node, c);
      const double value = is_held(node, c) ? stiff : diagonal[c][node];
      check(MatSetValues(matrix, 1, &at, 1, &at, &value, ADD_VALUES), "fill a matrix");
    }
  check(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY), "assemble a matrix");
  check(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY), "assemble a matrix");
  check(MatSetOption(matrix, MAT_SPD, PETSC_TRUE), "declare a matrix positive definite");
}

// Translations and rotations, the near null space of an elastic solid. Smoothed aggregation needs
// them to coarsen well.
void LinearSystem::Handles::set_rigid_motions() {
  OwnedVec places;
  check(VecDuplicate(right, places.create()), "create a vector");
  check(VecSetBlockSize(places, components), "set the size of a vector");
  PetscScalar* x = nullptr;
  check(VecGetArray(places, &x), "access the array of a vector");
  for (std::size_t n = 0; n < mesh.own.size(); ++n) {
    const Vec3 at = mesh.position(mesh.own[n]);
    for (int c = 0; c < components; ++c)
      x[n * static_cast<std::size_t>(components) + static_cast<std::size_t>(c)] =
          at[mesh.lattice.axis(c)];
  }
  check(VecRestoreArray(places, &x), "restore the array of a vector");
  OwnedNullSpace motions;
  check(MatNullSpaceCreateRigidBody(places, motions.create()), "form the rigid motions");
  check(MatSetNearNullSpace(matrix, motions), "set the rigid motions");
}

Nodal LinearSystem::stiffness_diagonal() const {
  const Handles& h = *handles_;
  Nodal own(h.components, h.mesh.nodes());
  check(MatGetDiagonal(h.matrix, h.right), "get the diagonal");
  h.from_petsc(h.right, own);
  for (int c = 0; c < h.components; ++c)
    for (const std::int32_t n : h.mesh.own)
      own[c][n] = h.is_held(n, c) ? 0 : own[c][n] - h.diagonal[c][n];
  return own;
}

// If inertia dominates over stiffness, scaling by the diagonal takes few iterations, each at the
// cost of a product; otherwise multigrid is better. A single solve in a plane uses BoomerAMG, which
// takes half of gamg's iterations beside stiff blocks; but one of its iterations costs as much as
// ten of gamg's, which is too expensive in every step (docs/decisions/ground_elements.md).
const char* LinearSystem::Handles::default_preconditioner(Use use) {
  // Stiffness over inertia on the diagonal at which gamg costs as much: 220 and 110 iterations.
  const double most = components == 3 ? 400 : 70;
  const PetscScalar* all = nullptr;
  check(MatGetDiagonal(matrix, right), "get the diagonal");
  check(VecGetArrayRead(right, &all), "access a vector");
  double ratio = 0;
  std::size_t at = 0;
  for (const std::int32_t n : mesh.own)
    for (int c = 0; c < components; ++c, ++at)
      if (!is_held(n, c)) ratio = std::max(ratio, all[at] / std::max(diagonal[c][n], 1e-300));
  check(VecRestoreArrayRead(right, &all), "restore the array of a vector");
  if (mesh.comm.max(ratio) <= most) return PCJACOBI;
  return components == 3 || use == Use::in_every_step ? PCGAMG : PCHYPRE;
}

// The unpreconditioned residual is a force, as the tolerance of the deck means. The limit of
// iterations is for failures: a good solve takes some ten iterations, tetrahedra at nu = 0.4999
// take 1400 to 1700 on any mesh, growing as (1 - 2 nu)^-1/2.
void LinearSystem::Handles::make_solver(const Spec& spec) {
  if (suggest("ksp_type", "cg")) suggest("ksp_norm_type", "unpreconditioned");
  PetscBool given = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, prefix, "-pc_type", &given), "read its options");
  const char* type = default_preconditioner(spec.use);
  if (given == PETSC_TRUE ? suggest("pc_type", PCHYPRE) : std::string(type) == PCHYPRE) {
    suggest("pc_hypre_type", "boomeramg");
    suggest("pc_hypre_boomeramg_strong_threshold", components == 3 ? "0.5" : "0.25");
    suggest("pc_hypre_boomeramg_relax_type_all", "symmetric-SOR/Jacobi");
  }
  check(KSPCreate(par::mpi(mesh.comm), solver.create()), "create a solver");
  check(KSPSetOptionsPrefix(solver, prefix), "name a solver");
  PC preconditioner = nullptr;
  check(KSPGetPC(solver, &preconditioner), "get the preconditioner");
  check(PCSetType(preconditioner, type), "set the type of a preconditioner");
  check(KSPSetOperators(solver, product, matrix), "set the matrix of a solver");
  constexpr PetscInt most = 5000;
  check(KSPSetTolerances(solver, spec.tolerance, PETSC_DEFAULT, PETSC_DEFAULT, most),
        "set the tolerance");
  set_from_options(solver);
  check(KSPGetTolerances(solver, &tolerance, nullptr, nullptr, nullptr), "get the tolerance");
  set_up(solver);
}

LinearSystem::LinearSystem(Mesh& mesh, const Stiffness& stiffness, const Spec& spec) {
  Petsc::ensure();
  handles_ = std::make_unique<Handles>(mesh, stiffness, spec);
  handles_->create();
  handles_->assemble(spec);
  handles_->make_product();
  handles_->set_rigid_motions();
  handles_->make_solver(spec);
}

LinearSystem::~LinearSystem() = default;

void LinearSystem::Handles::to_petsc(const Nodal& from, Vec to) const {
  PetscScalar* values = nullptr;
  check(VecGetArray(to, &values), "access the array of a vector");
  std::size_t at = 0;
  for (const std::int32_t node : mesh.own)
    for (int c = 0; c < components; ++c) values[at++] = is_held(node, c) ? 0 : from[c][node];
  check(VecRestoreArray(to, &values), "restore the array of a vector");
}

void LinearSystem::Handles::from_petsc(Vec from, Nodal& to) const {
  const PetscScalar* values = nullptr;
  check(VecGetArrayRead(from, &values), "access the array of a vector");
  std::size_t at = 0;
  for (const std::int32_t node : mesh.own)
    for (int c = 0; c < components; ++c) to[c][node] = values[at++];
  check(VecRestoreArrayRead(from, &values), "restore the array of a vector");
}

int LinearSystem::Handles::outcome(KSP of) {
  // The reason is the same on every rank, so all throw together.
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  check(KSPGetConvergedReason(of, &reason), "get the reason of convergence");
  check(KSPGetIterationNumber(of, &iterations), "get the number of iterations");
  if (reason < 0)
    throw RunError(fmt::format(
        "the linear solver of the ground did not converge ({} iterations, {}); {}", iterations,
        KSPConvergedReasons[reason],
        reason == KSP_DIVERGED_ITS
            ? "poisson near 0.5 and ground materials (layers, blocks, solids) of very unequal "
              "stiffness need many iterations; allow more iterations (after `--`: "
              "-ground_ksp_max_it N) or use a direct solver (after `--`: -ground_ksp_type preonly "
              "-ground_pc_type cholesky -ground_pc_factor_mat_solver_type mumps)"
            : "if the reason is DIVERGED_NANORINF, the load on the ground is not finite: reduce "
              "the "
              "time steps; if the solver is direct, check the memory; in all other cases use a "
              "direct solver (after `--`: -ground_ksp_type preonly -ground_pc_type cholesky "
              "-ground_pc_factor_mat_solver_type "
              "mumps)"));
  return static_cast<int>(iterations);
}

// PETSc regards a preconditioner applied once (preonly) as converged, whatever its residual.
void LinearSystem::Handles::require_solved(double all) {
  constexpr double rounding = 1e-4;  // far above the relative residual of a direct solver
  PetscBool once = PETSC_FALSE;
  check(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(KSP(solver)), KSPPREONLY, &once),
        "get the type of a solver");
  if (once == PETSC_FALSE) return;
  PetscReal left = 0;
  check(MatMult(product, solution, residual), "multiply by a matrix");
  check(VecAYPX(residual, -1, right), "add vectors");
  check(VecNorm(residual, NORM_2, &left), "compute the norm of a vector");
  if (!(left <= rounding * all))
    throw RunError(
        fmt::format("the linear solver of the ground leaves a residual of {:.2g} times the forces "
                    "(limit {:g}); use -ground_ksp_type preonly with direct solvers only "
                    "(-ground_pc_type cholesky or lu)",
                    left / all, rounding));
}

// Solves for the correction of the guess. Given the guess itself, PETSc measures divergence
// relative to the right-hand side: if that almost vanishes from one step to the next it stops at
// once, and near that it would try to reduce the rounding error of the guess. A guess worse than
// zero is dropped, so that the residual to be solved is never larger than the right-hand side.
//
// Fixed unknowns have a row of their own with 0 on the right-hand side: their solution is 0.
int LinearSystem::solve(const Nodal& right_side, Nodal& x, double floor) {
  Handles& h = *handles_;
  PetscReal all = 0, left = 0;
  h.to_petsc(right_side, h.right);
  h.to_petsc(x, h.solution);
  check(MatMult(h.product, h.solution, h.residual), "multiply by a matrix");
  check(VecAYPX(h.residual, -1, h.right), "add vectors");
  check(VecNorm(h.right, NORM_2, &all), "compute the norm of a vector");
  check(VecNorm(h.residual, NORM_2, &left), "compute the norm of a vector");
  if (left >= all) {
    check(VecSet(h.solution, 0), "set a vector to zero");
    check(VecCopy(h.right, h.residual), "copy a vector");
    left = all;
  }
  const double enough = std::max(h.tolerance * all, floor);
  int iterations = 0;
  if (!(left <= enough)) {  // or NaN, which the solver reports
    const double relative = std::isfinite(left) ? enough / left : h.tolerance;
    check(KSPSetTolerances(h.solver, relative, PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT),
          "set the tolerance");
    check(KSPSolve(h.solver, h.residual, h.correction), "solve the ground");
    iterations = Handles::outcome(h.solver);
    check(VecAXPY(h.solution, 1, h.correction), "add vectors");
    h.require_solved(all);
  }
  h.from_petsc(h.solution, x);
  return iterations;
}

}  // namespace trackbed::fem
