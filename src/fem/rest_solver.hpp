// K x = b with the same bits on any number of ranks: conjugate gradients (Hestenes, Stiefel 1952,
// doi:10.6028/jres.049.044), Jacobi-preconditioned, matrix-free on the kernel of the explicit step,
// with sums that do not depend on the split (core/exact_sum.hpp).
//
// For the rest of grounds that yield: what flows later hangs on every bit of it. An iteration costs
// some explicit steps and four reductions; their number grows with the zones across the model,
// which PETSc's multigrid avoids and pays for in bits. Rejected: rounding PETSc's solution (values
// on the brink of rounding still differ), solving on one rank alone (memory).
#pragma once

#include "mesh.hpp"
#include "stiffness.hpp"
#include "terms.hpp"

namespace trackbed::fem {

// Springs count, borders are those of rest (Terms::held_at_rest).
class RestSolver {
 public:
  RestSolver(Mesh& mesh, const Stiffness& stiffness, const Terms& terms);

  // From the x given until the residual of `right` (N, own nodes) is `tolerance` of `size` (N, root
  // of `squared`). Returns the iterations; throws RunError on all ranks if there are too many.
  // Ghosts of x are current afterwards. Collective.
  int solve(const Nodal& right, Nodal& x, double tolerance, double size);
  // Sum of squares over freedoms that can move, N^2. Collective.
  double squared(const Nodal& force) const;

 private:
  void apply(Nodal& x, Nodal& force);  // held freedoms: 0
  std::array<double, 2> products(const Nodal& a, const Nodal& b, const Nodal& c) const;

  Mesh& mesh_;
  const Stiffness& stiffness_;
  const Terms& terms_;
  double terms_count_;  // of a sum over all ranks
  Nodal inverse_;       // 1/(N/m) of the diagonal; 0: held, ghost
};

}  // namespace trackbed::fem
