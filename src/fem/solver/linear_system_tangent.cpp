// The tangent of Newton's method: a copy of the constant matrix to which elements add, and its
// solver.
//
// The copy has the pattern of the matrix, since only entries of elements change. Its preconditioner
// is that of the constant matrix, unchanged: plastic elements are softer, but few, and each costs
// GMRES some iterations; a new hierarchy in each iteration of Newton would cost more. GMRES uses
// right preconditioning, so that the tolerance refers to forces. Near collapse without inertia
// (very long steps) so many elements are soft that this fails: then, and only then, the tangent is
// factorised (MUMPS: Amestoy, Duff, L'Excellent, Koster 2001, doi:10.1137/S0895479899358194).
#include "fem/solver/linear_system_handles.hpp"
#include "fem/solver/petsc_check.hpp"
#include "trackbed/par/mpi.hpp"

namespace trackbed::fem {

namespace {

// The preconditioner of the elastic solver, as that of the tangent.
PetscErrorCode apply_elastic(PC shell, Vec from, Vec to) {
  void* context = nullptr;
  const PetscErrorCode code = PCShellGetContext(shell, &context);
  return code != 0 ? code : PCApply(static_cast<PC>(context), from, to);
}

}  // namespace

// Vectors kept per restart: memory against convergence; most solves end before the first restart.
void LinearSystem::Handles::make_tangent() {
  if (tangent_solver != nullptr) return;
  constexpr PetscInt kept = 100, most = 300;
  check(MatDuplicate(matrix, MAT_SHARE_NONZERO_PATTERN, tangent.create()), "copy a matrix");
  check(KSPCreate(par::mpi(mesh.comm), tangent_solver.create()), "create a solver");
  check(KSPSetOptionsPrefix(tangent_solver, "ground_tangent_"), "name a solver");
  check(KSPSetType(tangent_solver, KSPGMRES), "set the type of a solver");
  check(KSPGMRESSetRestart(tangent_solver, kept), "set the restart");
  check(KSPSetPCSide(tangent_solver, PC_RIGHT), "set the side of a preconditioner");
  check(KSPSetTolerances(tangent_solver, PETSC_DEFAULT, 0, PETSC_DEFAULT, most),
        "set the tolerance");
  PC shell = nullptr, elastic = nullptr;
  check(KSPGetPC(solver, &elastic), "get the preconditioner");
  check(KSPGetPC(tangent_solver, &shell), "get the preconditioner");
  check(PCSetType(shell, PCSHELL), "set the type of a preconditioner");
  check(PCShellSetContext(shell, elastic), "set a preconditioner");
  check(PCShellSetApply(shell, apply_elastic), "set a preconditioner");
  set_from_options(tangent_solver);
  PetscBool given = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, "ground_tangent_", "-ksp_rtol", &given), "read its options");
  if (given == PETSC_TRUE)
    check(KSPGetTolerances(tangent_solver, &of_tangent, nullptr, nullptr, nullptr),
          "get the tolerance");
}

void LinearSystem::Handles::set_up_tangent() {
  check(MatAssemblyBegin(tangent, MAT_FINAL_ASSEMBLY), "assemble a matrix");
  check(MatAssemblyEnd(tangent, MAT_FINAL_ASSEMBLY), "assemble a matrix");
  check(KSPSetOperators(tangent_solver, tangent, tangent), "set the matrix of a solver");
  set_up(tangent_solver);
}

void LinearSystem::Handles::make_direct() {
  if (direct != nullptr) return;
  check(KSPCreate(par::mpi(mesh.comm), direct.create()), "create a solver");
  check(KSPSetOptionsPrefix(direct, "ground_tangent_direct_"), "name a solver");
  check(KSPSetType(direct, KSPPREONLY), "set the type of a solver");
  PC factors = nullptr;
  check(KSPGetPC(direct, &factors), "get the preconditioner");
  check(PCSetType(factors, PCLU), "set the type of a preconditioner");
  check(PCFactorSetMatSolverType(factors, MATSOLVERMUMPS), "select the direct solver");
  set_from_options(direct);
}

// The direct solver is set up without factorising.
void LinearSystem::try_changed() {
  Handles& h = *handles_;
  h.make_tangent();
  check(MatCopy(h.matrix, h.tangent, SAME_NONZERO_PATTERN), "copy a matrix");
  h.set_up_tangent();
  h.make_direct();
  check(KSPSetOperators(h.direct, h.tangent, h.tangent), "set the matrix of a solver");
  set_up_factors(h.direct);
}

int LinearSystem::solve_changed(const Changes& changes, const Nodal& right_side, double tolerance,
                                Nodal& x) {
  Handles& h = *handles_;
  h.make_tangent();
  check(MatCopy(h.matrix, h.tangent, SAME_NONZERO_PATTERN), "copy a matrix");
  changes([&](std::size_t element, const Eigen::MatrixXd& k) {
    h.add_element(h.tangent, element, k, 1);
  });
  h.set_up_tangent();
  check(KSPSetTolerances(h.tangent_solver, h.of_tangent > 0 ? h.of_tangent : tolerance,
                         PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT),
        "set the tolerance");
  h.to_petsc(right_side, h.right);
  check(KSPSolve(h.tangent_solver, h.right, h.solution), "solve the ground");
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(h.tangent_solver, &reason), "get the reason of convergence");
  PetscInt iterations = 0;
  check(KSPGetIterationNumber(h.tangent_solver, &iterations), "get the number of iterations");
  if (reason < 0) {
    h.make_direct();
    check(KSPSetOperators(h.direct, h.tangent, h.tangent), "set the matrix of a solver");
    set_up(h.direct);
    check(KSPSolve(h.direct, h.right, h.solution), "solve the ground");
    check(KSPGetConvergedReason(h.direct, &reason), "get the reason of convergence");
    if (reason < 0) return -1;
  }
  h.from_petsc(h.solution, x);
  return static_cast<int>(iterations);
}

double LinearSystem::residual(const Nodal& right_side, const Nodal& x, Nodal& r) {
  Handles& h = *handles_;
  PetscReal norm = 0;
  h.to_petsc(x, h.solution);
  h.to_petsc(right_side, h.right);
  check(MatMult(h.product, h.solution, h.residual), "multiply by a matrix");
  check(VecAXPY(h.right, -1, h.residual), "add vectors");
  check(VecNorm(h.right, NORM_2, &norm), "compute the norm of a vector");
  h.from_petsc(h.right, r);
  return norm;
}

}  // namespace trackbed::fem
