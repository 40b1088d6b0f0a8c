// The tangent of Newton: a copy of the constant matrix to which zones add, and its solver.
//
// The copy has the pattern of the matrix, since zones that flow are zones. Its preconditioner is
// that of the constant matrix, applied as it stands: what flows is softer, in few zones, and each
// costs GMRES some iterations; a new hierarchy in each round would cost more than all of them.
// GMRES on the right side of the preconditioner, so that the tolerance is one of forces. Near
// collapse without inertia (very long steps) so much is soft that this fails: then, and only then,
// the tangent is factorised (MUMPS: Amestoy, Duff, L'Excellent, Koster 2001,
// doi:10.1137/S0895479899358194).
#include "linear_system_handles.hpp"
#include "petsc_check.hpp"
#include "trackbed/par/mpi.hpp"

namespace trackbed::fem {

namespace {

// The elastic solver's preconditioner within the tangent's.
PetscErrorCode apply_elastic(PC shell, Vec from, Vec to) {
  void* context = nullptr;
  const PetscErrorCode code = PCShellGetContext(shell, &context);
  return code != 0 ? code : PCApply(static_cast<PC>(context), from, to);
}

}  // namespace

// Kept vectors per restart: memory against convergence; most solves end before the first one.
void LinearSystem::Handles::make_tangent() {
  if (tangent_solver != nullptr) return;
  constexpr PetscInt kept = 100, most = 300;
  check(MatDuplicate(matrix, MAT_SHARE_NONZERO_PATTERN, &tangent), "copy a matrix");
  check(KSPCreate(par::mpi(mesh.comm), &tangent_solver), "create a solver");
  check(KSPSetOptionsPrefix(tangent_solver, "ground_tangent_"), "name a solver");
  check(KSPSetType(tangent_solver, KSPGMRES), "type a solver");
  check(KSPGMRESSetRestart(tangent_solver, kept), "set the restart");
  check(KSPSetPCSide(tangent_solver, PC_RIGHT), "set a side");
  check(KSPSetTolerances(tangent_solver, PETSC_DEFAULT, 0, PETSC_DEFAULT, most),
        "set the tolerance");
  PC shell = nullptr, elastic = nullptr;
  check(KSPGetPC(solver, &elastic), "find a preconditioner");
  check(KSPGetPC(tangent_solver, &shell), "find a preconditioner");
  check(PCSetType(shell, PCSHELL), "type a preconditioner");
  check(PCShellSetContext(shell, elastic), "set a preconditioner");
  check(PCShellSetApply(shell, apply_elastic), "set a preconditioner");
  take_options(tangent_solver);
  PetscBool given = PETSC_FALSE;
  check(PetscOptionsHasName(nullptr, "ground_tangent_", "-ksp_rtol", &given), "read its options");
  if (given == PETSC_TRUE)
    check(KSPGetTolerances(tangent_solver, &of_tangent, nullptr, nullptr, nullptr),
          "ask for the tolerance");
}

void LinearSystem::Handles::set_up_tangent() {
  check(MatAssemblyBegin(tangent, MAT_FINAL_ASSEMBLY), "assemble a matrix");
  check(MatAssemblyEnd(tangent, MAT_FINAL_ASSEMBLY), "assemble a matrix");
  check(KSPSetOperators(tangent_solver, tangent, tangent), "give a solver its matrix");
  set_up(tangent_solver);
}

void LinearSystem::Handles::make_direct() {
  if (direct != nullptr) return;
  check(KSPCreate(par::mpi(mesh.comm), &direct), "create a solver");
  check(KSPSetOptionsPrefix(direct, "ground_tangent_direct_"), "name a solver");
  check(KSPSetType(direct, KSPPREONLY), "type a solver");
  PC factors = nullptr;
  check(KSPGetPC(direct, &factors), "find a preconditioner");
  check(PCSetType(factors, PCLU), "type a preconditioner");
  check(PCFactorSetMatSolverType(factors, MATSOLVERMUMPS), "choose who factorises");
  take_options(direct);
}

// Who factorises is found without factorising.
void LinearSystem::try_changed() {
  Handles& h = *handles_;
  h.make_tangent();
  check(MatCopy(h.matrix, h.tangent, SAME_NONZERO_PATTERN), "copy a matrix");
  h.set_up_tangent();
  h.make_direct();
  check(KSPSetOperators(h.direct, h.tangent, h.tangent), "give a solver its matrix");
  find_factors(h.direct);
}

int LinearSystem::solve_changed(const Changes& changes, const Nodal& right_side, double tolerance,
                                Nodal& x) {
  Handles& h = *handles_;
  h.make_tangent();
  check(MatCopy(h.matrix, h.tangent, SAME_NONZERO_PATTERN), "copy a matrix");
  changes([&](std::size_t zone, const Eigen::MatrixXd& k) { h.add_zone(h.tangent, zone, k, 1); });
  h.set_up_tangent();
  check(KSPSetTolerances(h.tangent_solver, h.of_tangent > 0 ? h.of_tangent : tolerance,
                         PETSC_DEFAULT, PETSC_DEFAULT, PETSC_DEFAULT),
        "set the tolerance");
  h.give(right_side, h.right);
  check(KSPSolve(h.tangent_solver, h.right, h.solution), "solve the ground");
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(h.tangent_solver, &reason), "say why it stopped");
  PetscInt iterations = 0;
  check(KSPGetIterationNumber(h.tangent_solver, &iterations), "count iterations");
  if (reason < 0) {
    h.make_direct();
    check(KSPSetOperators(h.direct, h.tangent, h.tangent), "give a solver its matrix");
    set_up(h.direct);
    check(KSPSolve(h.direct, h.right, h.solution), "solve the ground");
    check(KSPGetConvergedReason(h.direct, &reason), "say why it stopped");
    if (reason < 0) return -1;
  }
  h.take(h.solution, x);
  return static_cast<int>(iterations);
}

double LinearSystem::residual(const Nodal& right_side, const Nodal& x, Nodal& r) {
  Handles& h = *handles_;
  PetscReal norm = 0;
  h.give(x, h.solution);
  h.give(right_side, h.right);
  check(MatMult(h.product, h.solution, h.open), "multiply by a matrix");
  check(VecAXPY(h.right, -1, h.open), "add vectors");
  check(VecNorm(h.right, NORM_2, &norm), "measure a vector");
  h.take(h.right, r);
  return norm;
}

}  // namespace trackbed::fem
