// The ground beside the model, as columns that move with the wave from below only, and the forces
// of the columns and of the base on the border nodes of the model (Zienkiewicz, Bicanic, Shen 1989,
// doi:10.1007/978-3-7091-2828-2_2; Wolf 1988, Soil-Structure-Interaction Analysis in Time Domain).
//
// A column is a stack of elements of the model whose corners at one height move together: a chain
// per component, with the masses, stiffness, damping and viscous base of the elements. On a side
// node of the model act the dashpots of a viscous side, with its velocity relative to the column,
// and the force f of the column's elements on their neighbours across that side: half of f at a
// corner minus f at the opposite corner along the normal. So a model whose elements move as the
// columns is not disturbed by its sides, to rounding, and sides of other kinds receive no force.
//
// Columns are small compared with the model and are computed on every rank: without messages, and
// bitwise identical on any number of ranks. Solids do not change across the track, so there is one
// column for each element along it (a plane model needs the two at its ends), which is used for
// both lateral sides. Neighbouring columns of different solids do not interact. Rejected: plane
// free fields beside the lateral sides, a second model each. A ground from a mesh file has no
// columns, only the wave.
#pragma once

#include <functional>
#include <vector>

#include "fem/boundary/terms.hpp"
#include "fem/kernel/stiffness.hpp"
#include "fem/mesh/mesh.hpp"
#include "fem/time/alpha_scheme.hpp"
#include "fem/time/base_motion.hpp"

namespace trackbed::fem {

class FreeField {
 public:
  FreeField(const Mesh& mesh, const GroundParameters& parameters, const Stiffness& stiffness);

  // One step of the columns to the time `end` (s), by the scheme of the model around it.
  void explicit_step(double h, double end);
  void implicit_step(double dt, const AlphaScheme& scheme, double end);
  // Subtracts the forces of wave and columns on border nodes from the internal force (N) of own
  // nodes, at the time level of the last step; for implicit steps weighted between both ends as in
  // their equation.
  void act_on(Nodal& internal) const;
  void reset();

  // State, listed once: displacement (m), velocity (m/s), acceleration (m/s^2) of the columns, with
  // the components of a level together and levels from the base up. The same on every rank.
  using Visit = std::function<void(const char*, const char*, std::vector<double>&)>;
  void list(const Visit& visit);

 private:
  struct Chain {  // between two levels of a column
    std::int32_t solid;
    double damping;       // s, stiffness-proportional
    double stiffness[3];  // N/m
  };
  // A corner of an element at a border of the model.
  struct SideCorner {
    std::int32_t node, corner;
    std::size_t hold, chain;  // indices into hold_ and chains_
    double dashpots[3];       // N s/m
  };
  // Motion of elements, dashpots and base that enters the equation being solved.
  struct MixedMotion {
    std::vector<double> displacement, damped, velocity;
    Vec3 wave;  // m/s
  };

  void make_column(const Mesh& mesh, const GroundParameters& parameters, const Stiffness& stiffness,
                   std::int64_t i);
  void find_corners(const Mesh& mesh, const GroundParameters& parameters);
  void compute_forces();
  void solve(std::size_t column, int c, double dt, const AlphaScheme& scheme);
  std::size_t index(std::size_t column, std::size_t level, int c) const {
    return (column * (elements_ + 1) + level) * static_cast<std::size_t>(components_) +
           static_cast<std::size_t>(c);
  }

  BaseMotion motion_;
  int components_;
  std::size_t elements_, columns_ = 0;  // elements of a column
  std::vector<Chain> chains_;           // column by column, from the base up
  std::vector<double> mass_, damping_;  // kg, N s/m per entry of the state (mass damping, base)
  std::vector<double> foot_;            // N s/m, dashpots of each column's foot, per component
  // Of each solid, for each normal: forces on corners from the motion of two levels.
  std::vector<Eigen::MatrixXd> hold_;
  std::vector<SideCorner> sides_;
  std::vector<BasePart> base_;
  std::vector<double> displacement_, velocity_, acceleration_;
  std::vector<double> force_;  // N, scratch, as are the next ones, for implicit steps
  std::vector<double> displacement_before_, velocity_before_, diagonal_, above_;
  MixedMotion mixed_;
};

}  // namespace trackbed::fem
