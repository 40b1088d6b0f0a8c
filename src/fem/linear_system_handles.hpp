// Inside of LinearSystem: PETSc's objects, for its elastic part and its tangent
// (linear_system_tangent.cpp).
#pragma once

#include <petscksp.h>

#include "linear_system.hpp"

namespace trackbed::fem {

// PETSc's objects, destroyed in one place, and how they are filled.
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
  ~Handles() {
    // Static destruction after PetscFinalize would be an error of PETSc's.
    PetscBool running = PETSC_FALSE;
    PetscInitialized(&running);
    if (running == PETSC_FALSE) return;
    KSPDestroy(&direct);
    KSPDestroy(&tangent_solver);
    KSPDestroy(&solver);
    MatDestroy(&tangent);
    MatDestroy(&product);
    MatDestroy(&matrix);
    VecDestroy(&right);
    VecDestroy(&solution);
    VecDestroy(&open);
    VecDestroy(&correction);
  }
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;

  // In this order: sizes, numbers, rigid motions, solver.
  void create();
  std::vector<PetscInt> entries() const;
  void assemble(const Spec& spec);
  // Into rows of own nodes of a matrix.
  void add_zone(Mat to, std::size_t zone, const Eigen::MatrixXd& stiffness, double factor);
  void tell_rigid_motions();
  void make_product();
  void list_rows();
  void multiply(Vec from, Vec to);
  static int multiply_shell(Mat shell, Vec from, Vec to);
  const char* chosen(Use use);  // preconditioner, unless the user chooses
  void make_solver(const Spec& spec);
  void make_tangent();
  void set_up_tangent();
  void make_direct();
  bool is_held(std::int32_t node, int c) const {
    return (held[static_cast<std::size_t>(node)] >> c & 1) != 0;
  }
  // Between own nodes and PETSc's vectors; held freedoms give 0.
  void give(const Nodal& from, Vec to) const;
  void take(Vec from, Nodal& to) const;
  // Throws RunError on all ranks if the solver gave up; its iterations otherwise.
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
  Nodal motion, force, damped;  // scratch of a product
  struct Rows {
    std::int32_t node, nodes;  // own nodes that follow one another
    std::size_t at;            // first row of this rank
  };
  std::vector<Rows> rows;
  std::vector<double> free_row, on_diagonal;  // of each row: 0 if held, else 1; N/m
  double stiff = 0;                           // N/m, of the rows of held freedoms
  double tolerance = 0;                       // residual over right-hand side, the user's if given
  double of_tangent = 0;                      // the same of its solver; 0: not given
  Mat matrix = nullptr, product = nullptr;    // assembled; by the kernel
  Mat tangent = nullptr;                      // with its solver once asked for
  KSP solver = nullptr, tangent_solver = nullptr, direct = nullptr;
  Vec right = nullptr, solution = nullptr, open = nullptr, correction = nullptr;
};

}  // namespace trackbed::fem
