// Product of the system matrix and a vector by the kernel of the explicit step.
//
// 312 flops per element in space and no matrix to load: steps take a half to a tenth of the time
// that multigrid needs (docs/decisions/ground_elements.md). Rounding differs from that of the
// assembled matrix, which preconditioners and direct solvers still use.
#include <array>

#include "fem/solver/linear_system_handles.hpp"
#include "fem/solver/petsc_check.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/par/mpi.hpp"

namespace trackbed::fem {

namespace {

// PETSc vectors store the components of a node together, Nodal separately; consecutive own nodes
// are consecutive in both. Loops without branches, over whole vectors.

// to[c][n] = factor * x
template <int D>
void spread(std::int32_t nodes, const double* __restrict x, const double* __restrict factor,
            const std::array<double*, 3>& to) {
  for (std::int32_t n = 0; n < nodes; ++n)
    for (int c = 0; c < D; ++c) to[c][n] = factor[D * n + c] * x[D * n + c];
}

// y = factor * scale * from[c][n] + diagonal * x
template <int D>
void gather(std::int32_t nodes, const std::array<const double*, 3>& from, double scale,
            const double* __restrict factor, const double* __restrict diagonal,
            const double* __restrict x, double* __restrict y) {
  for (std::int32_t n = 0; n < nodes; ++n)
    for (int c = 0; c < D; ++c)
      y[D * n + c] = factor[D * n + c] * (scale * from[c][n]) + diagonal[D * n + c] * x[D * n + c];
}

}  // namespace

// Callback of PETSc; no exception may pass through it.
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
  check(MatGetLocalSize(matrix, &rows, nullptr), "get the size of a matrix");
  check(MatCreateShell(par::mpi(mesh.comm), rows, rows, PETSC_DETERMINE, PETSC_DETERMINE, this,
                       product.create()),
        "create a matrix");
  check(MatSetBlockSize(product, components), "set the size of a matrix");
  check(MatShellSetOperation(product, MATOP_MULT, reinterpret_cast<void (*)()>(multiply_shell)),
        "create a matrix");
  check(MatSetOption(product, MAT_SPD, PETSC_TRUE), "declare a matrix positive definite");
  list_rows();
}

// Fixed degrees of freedom have a row of their own.
void LinearSystem::Handles::list_rows() {
  const auto of_each = static_cast<std::size_t>(components);
  free_row.resize(mesh.own.size() * of_each);
  on_diagonal.resize(free_row.size());
  std::size_t at = 0;
  for (const std::int32_t n : mesh.own) {
    if (rows.empty() || rows.back().node + rows.back().nodes != n) rows.push_back({n, 0, at});
    ++rows.back().nodes;
    for (int c = 0; c < components; ++c, ++at) {
      free_row[at] = is_held(n, c) ? 0 : 1;
      on_diagonal[at] = is_held(n, c) ? stiff : diagonal[c][n];
    }
  }
}

// Fixed degrees of freedom are 0 in `motion`.
void LinearSystem::Handles::multiply(Vec from, Vec to) {
  const PetscScalar* x = nullptr;
  PetscScalar* y = nullptr;
  check(VecGetArrayRead(from, &x), "access the array of a vector");
  for (const Rows& r : rows)
    (components == 3 ? spread<3>
                     : spread<2>)(r.nodes, x + r.at, free_row.data() + r.at,
                                  {motion[0] + r.node, motion[1] + r.node, motion[2] + r.node});
  mesh.exchange(motion);
  stiffness.apply(motion, force);
  const bool damps = stiffness.damps() && damping != 0;
  if (damps) {
    damped.fill(0);
    stiffness.add_damping(motion, damped);
    for (int c = 0; c < components; ++c)
      for (std::size_t n = 0; n < mesh.nodes(); ++n)
        force[c][n] = common * force[c][n] + damping * damped[c][n];
  }
  check(VecGetArray(to, &y), "access the array of a vector");
  for (const Rows& r : rows)
    (components == 3 ? gather<3>
                     : gather<2>)(r.nodes,
                                  {force[0] + r.node, force[1] + r.node, force[2] + r.node},
                                  damps ? 1 : common, free_row.data() + r.at,
                                  on_diagonal.data() + r.at, x + r.at, y + r.at);
  check(VecRestoreArray(to, &y), "restore the array of a vector");
  check(VecRestoreArrayRead(from, &x), "restore the array of a vector");
}

}  // namespace trackbed::fem
