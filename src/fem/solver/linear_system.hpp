// Distributed linear system, sum of s K over the solids + diagonal, by PETSc: assembled once,
// solved many times.
//
// Iterations multiply with the kernel of the explicit step (linear_system_product.cpp), without
// loading a matrix; preconditioners are built from the assembled one.
//
// Default: conjugate gradients, in short steps with diagonal scaling, else with gamg, which uses
// the rigid-body motions; for a single solve in a plane with BoomerAMG on single unknowns (its
// nodal variants took six times more). Every default can be changed by PETSc options with the
// prefix `ground_`.
// `ground_`.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "fem/kernel/stiffness.hpp"
#include "fem/mesh/mesh.hpp"

namespace trackbed::fem {

// Owns the PETSc objects; refers to the mesh, which must outlive it.
class LinearSystem {
 public:
  enum class Use { once, in_every_step };
  struct Spec {
    std::vector<double> stiffness_factor;   // s of each solid
    Nodal diagonal;                         // N/m per component and node
    const std::vector<std::uint8_t>& held;  // bit c: the unknown is fixed to zero
    double tolerance = 1e-8;                // residual over right-hand side
    // The same factors in the form of Stiffness: s = common + damping (stiffness damping of the
    // solid minus the common one), s^2 and s if s is a time step.
    double common = 1, damping = 0;
    Use use = Use::once;  // decides the preconditioner
  };
  LinearSystem(Mesh& mesh, const Stiffness& stiffness, const Spec& spec);
  ~LinearSystem();

  // Solves for x of own nodes, with x as first guess or, if its residual is larger, with 0. `floor`
  // (N): rounding error of the right-hand side; a residual below it is accepted whatever the
  // tolerance. Returns the number of iterations, 0 if the guess is accepted. Throws RunError on all
  // ranks if the solve does not converge. Collective.
  int solve(const Nodal& right_side, Nodal& x, double floor = 0);

  // For Newton's method, whose tangent differs from the matrix in some elements. Calls of `Add`
  // name a local element and the matrix to be added there (N/m, degrees of freedom as in
  // ElementMatrices, not necessarily symmetric); ranks that hold the same element must add the
  // same.
  using Add = std::function<void(std::size_t, const Eigen::MatrixXd&)>;
  using Changes = std::function<void(const Add&)>;
  // Solves the changed system from x = 0 until the residual is `tolerance` of the right-hand side
  // (or -ground_tangent_ksp_rtol): GMRES (Saad, Schultz 1986, doi:10.1137/0907058), options with
  // the prefix `ground_tangent_`, with the preconditioner of the matrix, which is not set up again.
  // Returns the number of iterations, -1 on all ranks if the system is singular.
  int solve_changed(const Changes& changes, const Nodal& right_side, double tolerance, Nodal& x);
  // Sets up these solvers; for the direct one of last resort only options are read. Collective.
  void try_changed();
  // Diagonal of the sum of s K alone, of own free degrees of freedom; others 0.
  Nodal stiffness_diagonal() const;
  // right_side - matrix x on own degrees of freedom, 0 on fixed ones; returns its norm, N.
  // Collective.
  double residual(const Nodal& right_side, const Nodal& x, Nodal& r);

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

}  // namespace trackbed::fem
