// Distributed linear system sum of s K over the solids + diagonal by PETSc: assembled once, solved
// many times.
//
// Iterations multiply by the kernel of the explicit step (linear_system_product.cpp): no matrix to
// load; the assembled one is what preconditioners are made of.
//
// Default: conjugate gradients, in short steps scaled by the diagonal, else with gamg, which knows
// the rigid body motions; for a single solve in a plane with BoomerAMG on the single unknowns (its
// nodal variants took six times more). Every choice is open through PETSc options with the prefix
// `ground_`.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "mesh.hpp"
#include "stiffness.hpp"

namespace trackbed::fem {

// Owns PETSc's objects; refers to the mesh, which must outlive it.
class LinearSystem {
 public:
  enum class Use { once, in_every_step };
  struct Spec {
    std::vector<double> stiffness_factor;   // s of each solid
    Nodal diagonal;                         // N/m per component and node
    const std::vector<std::uint8_t>& held;  // bit c: the unknown is zero
    double tolerance = 1e-8;                // residual over right-hand side
    // The same factors as Stiffness has them: s = common + damping (its stiffness damping less the
    // common one), s^2 and s if s is of a time step.
    double common = 1, damping = 0;
    Use use = Use::once;  // which preconditioner pays
  };
  LinearSystem(Mesh& mesh, const Stiffness& stiffness, const Spec& spec);
  ~LinearSystem();

  // Solves for x of own nodes, starting from the x given or, where that leaves a larger residual,
  // from 0. `floor` (N): a residual that is rounding of the right side, enough whatever the
  // tolerance. Returns the iterations, 0 if the start was good enough. Throws RunError on all ranks
  // if it does not converge. Collective.
  int solve(const Nodal& right_side, Nodal& x, double floor = 0);

  // For Newton, whose tangent differs from the matrix in some zones. Calls of `Add` name a local
  // zone and what comes to the matrix there (N/m, freedoms as in ZoneElement, of any symmetry);
  // ranks that share a zone must say the same.
  using Add = std::function<void(std::size_t, const Eigen::MatrixXd&)>;
  using Changes = std::function<void(const Add&)>;
  // Solves the changed system from x = 0 until the residual is `tolerance` of the right side (or
  // what -ground_tangent_ksp_rtol says): GMRES
  // (Saad, Schultz 1986, doi:10.1137/0907058), options with the prefix `ground_tangent_`, on the
  // preconditioner of the matrix, which is not set up anew. Returns the iterations, -1 on all ranks
  // if the system is singular.
  int solve_changed(const Changes& changes, const Nodal& right_side, double tolerance, Nodal& x);
  // Sets up its solvers but the last resort, whose options alone are read. Collective.
  void try_changed();
  // Sum of s K alone on its diagonal, of own freedoms that are not held; others 0.
  Nodal stiffness_diagonal() const;
  // right_side - matrix x on own freedoms, 0 on held ones; returns its norm, N. Collective.
  double residual(const Nodal& right_side, const Nodal& x, Nodal& r);

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

}  // namespace trackbed::fem
