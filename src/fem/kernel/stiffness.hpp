// Internal force f = K w without a matrix: the inner loop of the explicit ground.
//
// The stiffness of a box-shaped isotropic element has the symmetry of the box. In terms of sums and
// differences of its corner displacements along x, y, z (one sign pattern per corner), the 24x24
// matrix separates into eight blocks of 3x3 (in a plane 8x8 into four of 2x2): 264 flops per
// element instead of 1152 (312 with the assembly of forces; 24 more where moduli change along a
// run). Component c with pattern p belongs to block p ^ (1 << c). Consecutive elements along x that
// share a solid, or differ by a factor of Young's modulus, form a run; eight of them are computed
// at once, one per vector lane, with unit-stride loads. See docs/decisions/ground_elements.md.
#pragma once

#include <optional>
#include <vector>

#include "fem/kernel/tetrahedra.hpp"
#include "fem/mesh/mesh.hpp"
#include "fem/shape/element.hpp"

namespace trackbed::fem {

// Constant after construction; local. Cost: 312 flops per element, including assembly. A ground of
// tetrahedra does not use `matrices`: its forces are those of Tetrahedra.
class Stiffness {
 public:
  Stiffness(const Mesh& mesh, std::vector<ElementMatrices> matrices, double common_damping = 0);

  // f = K w on own nodes; ghosts of w must be current, f of ghosts is not meaningful.
  void apply(const Nodal& w, Nodal& f) const;
  // f += (beta - common_damping) K v over the elements of solids with another stiffness damping
  // beta (s): the part that `apply` to u + common_damping v does not include. `damps`: whether
  // there are any, the same on all ranks.
  bool damps() const { return damps_; }
  void add_damping(const Nodal& v, Nodal& f) const;
  const ElementMatrices& matrices(std::int32_t solid) const {
    return matrices_[static_cast<std::size_t>(solid)];
  }
  // N/m of a held element, degrees of freedom d * corner + component.
  Eigen::MatrixXd matrix(const Mesh& mesh, std::size_t element) const {
    return tetrahedra_ ? tetrahedra_->matrix(element) : matrices(mesh.solid[element]).stiffness;
  }
  const Tetrahedra& tetrahedra() const { return *tetrahedra_; }  // of a ground of tetrahedra
  std::size_t bytes() const {
    return runs_.capacity() * sizeof(Run) + factor_.capacity() * sizeof(double) +
           (tetrahedra_ ? tetrahedra_->bytes() : 0);
  }

  // Stiffness in patterns: block[g][c][d] couples component c with pattern g ^ (1 << c) to
  // component d.
  struct Blocks {
    double block[8][3][3];
  };

 private:
  void cut_into_runs(const Mesh& mesh);
  struct Run {
    std::int32_t elements, solid;      // the first of equal ones up to a factor
    std::array<std::int32_t, 4> line;  // first node of each line of nodes along x
    std::int32_t factors;              // begin of those of its elements; -1: all are 1
  };
  // Short enough for the forces of a run to stay in the first-level cache.
  static constexpr std::int32_t longest_run = 64;

  std::vector<ElementMatrices> matrices_;
  std::vector<Blocks> blocks_;  // of each solid
  std::vector<Run> runs_;
  // Stiffness of an element over that of the solid of its run; padded for a whole vector.
  std::vector<double> factor_;
  std::vector<Blocks> damping_;   // of each solid, blocks_ times its additional damping
  std::vector<Run> damped_runs_;  // of solids with additional damping
  std::optional<Tetrahedra> tetrahedra_;
  std::vector<Image> images_;
  bool damps_ = false;
  std::size_t nodes_;
  int components_;
};

}  // namespace trackbed::fem
