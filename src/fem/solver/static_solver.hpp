// Solves K x = b bitwise identically on any number of ranks: conjugate gradients (Hestenes, Stiefel
// 1952, doi:10.6028/jres.049.044), Jacobi-preconditioned, matrix-free with the kernel of the
// explicit step, with sums that do not depend on the partition (core/exact_sum.hpp).
//
// Used for static equilibrium of yielding grounds, because later plastic strain depends on every
// bit of it. An iteration costs some explicit steps and four reductions; the number of iterations
// increases with the number of elements across the model, which the multigrid of PETSc avoids at
// the price of results that depend on the partition. Rejected: rounding the solution of PETSc
// (values near a rounding boundary still differ), solving on one rank alone (memory).
// on the brink of rounding still differ), solving on one rank alone (memory).
#pragma once

#include "fem/boundary/terms.hpp"
#include "fem/kernel/stiffness.hpp"
#include "fem/mesh/mesh.hpp"

namespace trackbed::fem {

// Includes springs; static boundary conditions (Terms::held_static).
class StaticSolver {
 public:
  StaticSolver(Mesh& mesh, const Stiffness& stiffness, const Terms& terms);

  // Starts from the given x and stops when the residual of `right` (N, own nodes) is `tolerance` of
  // `size` (N, root of `squared`). Returns the number of iterations; throws RunError on all ranks
  // if there are too many. Ghosts of x are current afterwards. Collective.
  int solve(const Nodal& right, Nodal& x, double tolerance, double size);
  // Sum of squares over free degrees of freedom, N^2. Collective.
  double squared(const Nodal& force) const;

 private:
  void apply(Nodal& x, Nodal& force);  // fixed degrees of freedom: 0
  std::array<double, 2> products(const Nodal& a, const Nodal& b, const Nodal& c) const;

  Mesh& mesh_;
  const Stiffness& stiffness_;
  const Terms& terms_;
  double terms_count_;  // number of terms of a sum over all ranks
  Nodal inverse_;       // 1/(N/m) of the diagonal; 0: fixed, ghost
};

}  // namespace trackbed::fem
