// Private part of LinearSystem: PETSc objects of its elastic part and its tangent
// (linear_system_tangent.cpp).
#pragma once

#include <petscksp.h>

#include "fem/solver/linear_system.hpp"
#include "fem/solver/petsc_owned.hpp"

namespace trackbed::fem {

// PETSc objects and their set-up.
struct LinearSystem::Handles {
  Handles(Mesh& m, const Stiffness& k, const Spec& spec)
      : mesh(m),
        stiffness(k),
        components(m.lattice.components()),
        held(spec.held),
        diagonal(spec.diagonal),
        common(spec.common),
        damping(spec.damping),
        motion(components, m.nodes()),
        force(motion),
        damped(motion) {}
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;

  // Called in this order: sizes, numbers, rigid motions, solver.
  void create();
  std::vector<PetscInt> entries() const;
  void assemble(const Spec& spec);
  // Adds to rows of own nodes of a matrix.
  void add_element(Mat to, std::size_t element, const Eigen::MatrixXd& stiffness, double factor);
  void set_rigid_motions();
  void make_product();
  void list_rows();
  void multiply(Vec from, Vec to);
  static int multiply_shell(Mat shell, Vec from, Vec to);
  const char* default_preconditioner(Use use);  // unless the user sets one
  void make_solver(const Spec& spec);
  void make_tangent();
  void set_up_tangent();
  void make_direct();
  bool is_held(std::int32_t node, int c) const {
    return (held[static_cast<std::size_t>(node)] >> c & 1) != 0;
  }
  // Between own nodes and PETSc vectors; fixed degrees of freedom become 0.
  void to_petsc(const Nodal& from, Vec to) const;
  void from_petsc(Vec from, Nodal& to) const;
  // Number of iterations; throws RunError on all ranks if the solver did not converge.
  static int outcome(KSP of);
  void require_solved(double all);
  PetscInt row(std::int32_t node, int c) const {
    return static_cast<PetscInt>(number[static_cast<std::size_t>(node)] * components + c);
  }

  Mesh& mesh;
  const Stiffness& stiffness;
  int components;
  std::vector<std::int64_t> number;  // of local nodes among all ranks' own nodes
  std::vector<std::uint8_t> held;
  Nodal diagonal;
  double common, damping;       // factors of Stiffness::apply and add_damping
  Nodal motion, force, damped;  // scratch arrays of a product
  struct Rows {
    std::int32_t node, nodes;  // consecutive own nodes
    std::size_t at;            // first row of this rank
  };
  std::vector<Rows> rows;
  std::vector<double> free_row, on_diagonal;  // of each row: 0 if fixed, else 1; N/m
  double stiff = 0;                           // N/m, of the rows of fixed degrees of freedom
  double tolerance = 0;                       // residual over right-hand side
  double of_tangent = 0;                      // the same for the tangent solver; 0: not set
  // Solvers are declared after the matrices that they use: members are destroyed in reverse order.
  OwnedMat matrix, product;  // assembled; multiplies by the kernel
  OwnedMat tangent;          // created with its solver on first use
  OwnedVec right, solution, residual, correction;
  OwnedKSP solver, tangent_solver, direct;
};

}  // namespace trackbed::fem
