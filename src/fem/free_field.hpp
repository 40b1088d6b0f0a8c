// The ground beside the model, as columns that feel only the wave from below, and what they and the
// base do to the model's border nodes (Zienkiewicz, Bicanic, Shen 1989,
// doi:10.1007/978-3-7091-2828-2_2; Wolf 1988, Soil-Structure-Interaction Analysis in Time Domain).
//
// A column is a stack of the model's own zones whose corners at one height move together: a chain
// per component, with the zones' masses, stiffness, damping and quiet base. A side node of the
// model feels the dashpots of a quiet side, stretched by its velocity less the column's, and the
// force f with which the column's zones hold their neighbours across that side: half of f at a
// corner less f at the one opposite along the normal. So a model whose zones move as the columns do
// is not disturbed by its sides, to rounding, and sides of another kind get nothing of it.
//
// Columns are few numbers beside the model and are computed on every rank alike: no message, and
// the same bits on any number of ranks. Solids do not change across the track, so there is one
// column for each zone along it (a plane model needs the two at its ends), and it serves both
// lateral sides. Neighbouring columns of different solids do not feel each other. Rejected: plane
// free fields beside the lateral sides, a second model each. A ground from a mesh file has no
// columns, and the wave alone.
#pragma once

#include <functional>
#include <vector>

#include "alpha_scheme.hpp"
#include "base_motion.hpp"
#include "mesh.hpp"
#include "stiffness.hpp"
#include "terms.hpp"

namespace trackbed::fem {

class FreeField {
 public:
  FreeField(const Mesh& mesh, const GroundParameters& parameters, const Stiffness& stiffness);

  // One step of the columns to the time `end` (s), by the scheme of the model around it.
  void explicit_step(double h, double end);
  void implicit_step(double dt, const AlphaScheme& scheme, double end);
  // Takes what wave and columns do to border nodes off the internal force (N) of own nodes, at the
  // time level of the last step: for implicit steps what their equation takes of both ends.
  void act_on(Nodal& internal) const;
  void rest();

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
  // One corner of a zone at a border of the model.
  struct SideCorner {
    std::int32_t node, corner;
    std::size_t hold, chain;  // in hold_; of its column
    double dashpots[3];       // N s/m
  };
  // What zones, dashpots and base see of the motion in the equation being solved.
  struct Seen {
    std::vector<double> displacement, damped, velocity;
    Vec3 wave;  // m/s
  };

  void make_column(const Mesh& mesh, const GroundParameters& parameters, const Stiffness& stiffness,
                   std::int64_t i);
  void find_corners(const Mesh& mesh, const GroundParameters& parameters);
  void pull();
  void solve(std::size_t column, int c, double dt, const AlphaScheme& scheme);
  std::size_t index(std::size_t column, std::size_t level, int c) const {
    return (column * (zones_ + 1) + level) * static_cast<std::size_t>(components_) +
           static_cast<std::size_t>(c);
  }

  BaseMotion motion_;
  int components_;
  std::size_t zones_, columns_ = 0;     // zones of a column
  std::vector<Chain> chains_;           // column by column, from the base up
  std::vector<double> mass_, damping_;  // kg, N s/m per number of the state (mass damping, base)
  std::vector<double> foot_;            // N s/m, dashpots of each column's foot, per component
  // Of each solid, for each normal: forces on corners from the motion of two levels.
  std::vector<Eigen::MatrixXd> hold_;
  std::vector<SideCorner> sides_;
  std::vector<BasePart> base_;
  std::vector<double> displacement_, velocity_, acceleration_;
  std::vector<double> force_;  // N, scratch; what follows too, of implicit steps
  std::vector<double> displacement_before_, velocity_before_, diagonal_, above_;
  Seen seen_;
};

}  // namespace trackbed::fem
