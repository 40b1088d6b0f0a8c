// Internal force f = K w without a matrix: the inner loop of the explicit ground.
//
// The stiffness of a box-shaped isotropic zone keeps the symmetry of the box. Written in the sums
// and differences of its corner displacements along x, y, z (one pattern of signs per corner), the
// 24x24 matrix falls apart into eight blocks of 3x3 (in a plane 8x8 into four of 2x2): 264 flops
// per zone instead of 1152 (312 with the forces' assembly; 24 more where moduli change along a
// run). Component c with pattern p belongs to block p ^ (1 << c). Zones that
// follow one another along x and share a solid, or differ by a factor of Young's modulus, form a
// run; eight of them are worked on at once, one per vector lane, with unit-stride loads. See
// docs/decisions/ground_elements.md.
#pragma once

#include <optional>
#include <vector>

#include "element.hpp"
#include "mesh.hpp"
#include "tetrahedra.hpp"

namespace trackbed::fem {

// Constant once made; local. Cost: 312 flops per zone, assembly included. A mesh from a file has no
// use for `elements`: its forces are those of Tetrahedra, and `element` is not asked for.
class Stiffness {
 public:
  Stiffness(const Mesh& mesh, std::vector<ZoneElement> elements, double common_damping = 0);

  // f = K w on own nodes; ghosts of w must be current, f of ghosts is not meaningful.
  void apply(const Nodal& w, Nodal& f) const;
  // f += (beta - common_damping) K v over the zones of solids with another stiffness damping beta
  // (s): what `apply` on u + common_damping v leaves out. The same on all ranks whether there are
  // any.
  bool damps() const { return damps_; }
  void add_damping(const Nodal& v, Nodal& f) const;
  const ZoneElement& element(std::int32_t solid) const {
    return elements_[static_cast<std::size_t>(solid)];
  }
  // N/m of a zone held, freedoms d * corner + component.
  Eigen::MatrixXd matrix(const Mesh& mesh, std::size_t zone) const {
    return tetrahedra_ ? tetrahedra_->matrix(zone) : element(mesh.solid[zone]).stiffness;
  }
  const Tetrahedra& tetrahedra() const { return *tetrahedra_; }  // of a mesh from a file
  std::size_t bytes() const {
    return runs_.capacity() * sizeof(Run) + factor_.capacity() * sizeof(double) +
           (tetrahedra_ ? tetrahedra_->bytes() : 0);
  }

  // Stiffness in patterns: block[g][c][d] ties component c with pattern g ^ (1 << c) to component
  // d.
  struct Blocks {
    double block[8][3][3];
  };

 private:
  void cut_into_runs(const Mesh& mesh);
  struct Run {
    std::int32_t zones, solid;         // the first of those that are alike
    std::array<std::int32_t, 4> line;  // first node of each line of nodes along x
    std::int32_t factors;              // where those of its zones begin; -1: all are 1
  };
  // Short enough for the forces of a run to stay in the first-level cache.
  static constexpr std::int32_t longest_run = 64;

  std::vector<ZoneElement> elements_;
  std::vector<Blocks> blocks_;  // of each solid
  std::vector<Run> runs_;
  // What the matrix of a zone is of that of its run's solid; with room for a whole vector.
  std::vector<double> factor_;
  std::vector<Blocks> damping_;   // of each solid, blocks_ times what it damps more
  std::vector<Run> damped_runs_;  // of solids that damp more or less than the others
  std::optional<Tetrahedra> tetrahedra_;
  std::vector<Image> images_;
  bool damps_ = false;
  std::size_t nodes_;
  int components_;
};

}  // namespace trackbed::fem
