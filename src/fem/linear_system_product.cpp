// The product of the system's matrix and a vector by the kernel of the explicit step.
//
// 312 flops a zone in space and no matrix to load: steps take a half to a tenth of the time that
// multigrid needs (docs/decisions/ground_elements.md). Bits are not those of the assembled matrix,
// which preconditioners and direct solvers still get.
#include "linear_system_handles.hpp"
#include "petsc_check.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/par/mpi.hpp"

namespace trackbed::fem {

// PETSc's way of asking; no exception may pass through it.
int LinearSystem::Handles::multiply_shell(Mat shell, Vec from, Vec to) {
  void* context = nullptr;
  const PetscErrorCode code = MatShellGetContext(shell, &context);
  if (code != 0) return code;
  try {
    static_cast<Handles*>(context)->multiply(from, to);
  } catch (const RunError&) {
    return PETSC_ERR_LIB;
  }
  return 0;
}

void LinearSystem::Handles::make_product() {
  PetscInt rows = 0;
  check(MatGetLocalSize(matrix, &rows, nullptr), "ask for a size");
  check(MatCreateShell(par::mpi(mesh.comm), rows, rows, PETSC_DETERMINE, PETSC_DETERMINE, this,
                       &product),
        "create a matrix");
  check(MatSetBlockSize(product, components), "size a matrix");
  check(MatShellSetOperation(product, MATOP_MULT, reinterpret_cast<void (*)()>(multiply_shell)),
        "create a matrix");
  check(MatSetOption(product, MAT_SPD, PETSC_TRUE), "mark a matrix");
}

// Held freedoms are 0 in `motion` and have a row of their own.
void LinearSystem::Handles::multiply(Vec from, Vec to) {
  const PetscScalar* x = nullptr;
  PetscScalar* y = nullptr;
  check(VecGetArrayRead(from, &x), "open a vector");
  std::size_t at = 0;
  for (const std::int32_t n : mesh.own)
    for (int c = 0; c < components; ++c, ++at) motion[c][n] = is_held(n, c) ? 0 : x[at];
  mesh.exchange(motion);
  stiffness.apply(motion, force);
  if (stiffness.damps() && damping != 0) {
    damped.fill(0);
    stiffness.add_damping(motion, damped);
  }
  check(VecGetArray(to, &y), "open a vector");
  at = 0;
  for (const std::int32_t n : mesh.own)
    for (int c = 0; c < components; ++c, ++at)
      y[at] = is_held(n, c)
                  ? stiff * x[at]
                  : common * force[c][n] + damping * damped[c][n] + diagonal[c][n] * motion[c][n];
  check(VecRestoreArray(to, &y), "close a vector");
  check(VecRestoreArrayRead(from, &x), "close a vector");
}

}  // namespace trackbed::fem
