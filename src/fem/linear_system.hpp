// Distributed linear system sum of s K over the solids + diagonal by PETSc: assembled once, solved
// many times.
//
// Default: conjugate gradients with hypre's BoomerAMG on the single unknowns, 12 iterations for the
// static start of a transition zone; its nodal variants took six times more. The rigid body motions
// are attached for solvers that use them (gamg). Every choice is open through PETSc options with
// the prefix `ground_`.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "mesh.hpp"
#include "stiffness.hpp"

namespace trackbed::fem {

// Owns PETSc's objects; refers to the mesh, which must outlive it.
class LinearSystem {
 public:
  struct Spec {
    std::vector<double> stiffness_factor;   // s of each solid
    Nodal diagonal;                         // N/m per component and node
    const std::vector<std::uint8_t>& held;  // bit c: the unknown is zero
    double tolerance = 1e-8;                // residual over right-hand side
  };
  LinearSystem(Mesh& mesh, const Stiffness& stiffness, const Spec& spec);
  ~LinearSystem();

  // Solves for x of own nodes, starting from the x given. Returns the iterations. Throws RunError
  // on all ranks if it does not converge. Collective.
  int solve(const Nodal& right_side, Nodal& x);

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
};

}  // namespace trackbed::fem
