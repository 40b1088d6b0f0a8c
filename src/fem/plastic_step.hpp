// Zones that yield in an implicit step: plastic strain at its end from that at its begin, and the
// tangent that goes with it.
//
// Backward Euler with the enhanced strains in equilibrium, zone by zone. With e the plastic strain,
// its gain d, S and R those of Plasticity, R + D = Z Z^T of rank m (12 in space),
//   sigma = return(s + Z x),  s = S u + R e_begin,  d = D^-1 (s + Z x - sigma),  x = Z^T d:
// m equations for the enhanced strains x of a zone, solved by Newton. The tangent is consistent
// (Simo, Taylor 1985, doi:10.1016/0045-7825(85)90070-2): derivative of what is computed, so that
// Newton on the nodes converges quadratically. Unlike in explicit steps nothing lags, unless
// `follow` says so.
//
// Nothing of it is state: what stays of a step is the plastic strain. Cost per zone that flows:
// some 20 us a call, and for others the test of Plasticity. Rejected: enhanced strains that lag
// from round to round (linear convergence), as unknowns of the whole (half as many again).
#pragma once

#include <functional>
#include <vector>

#include "plasticity.hpp"

namespace trackbed::fem {

class PlasticStep {
 public:
  // Both must outlive it.
  PlasticStep(const Mesh& mesh, Plasticity& plasticity);

  // Plastic strain at the end of the step under the motion rest + u, whatever was tried before in
  // this step. Ghosts must be current. Local.
  void flow(const Nodal& rest, const Nodal& u);
  // Enhanced strains follow what flows in this step only in the next one, as in explicit steps, or
  // at once.
  enum class Follow { at_once, next_step };
  void follow(Follow when) { when_ = when; }
  // Zones held here that flow at the last motion tried.
  std::size_t flowing() const { return flows_.size(); }
  // Zones held here whose enhanced strains found no end at the last motion tried: their stress
  // belongs to no strain, so that a step must not end there.
  std::size_t lost() const { return lost_; }
  // The largest component of plastic strain in zones held here that flow, and of what this motion
  // adds to it.
  double largest_strain() const;
  double largest_gain() const;
  // Whether enhanced strains of all solids have a potential: dilation is friction.
  bool has_potential() const;
  // Calls visit(local zone, N/m) with what flow takes off the elastic stiffness there: freedoms as
  // in ZoneElement, not symmetric unless dilation is friction.
  using Visit = std::function<void(std::size_t, const Eigen::MatrixXd&)>;
  void tangent(const Visit& visit) const;
  // The last motion tried, u beyond rest, is the end of the step: its strain stays, its work is
  // counted, tetrahedra that have opened are told.
  void keep(const Nodal& u);
  // The strain of the begin comes back.
  void undo();

 private:
  struct Law {
    Elastic elastic;
    Strength strength;
    MohrCoulomb surface;
    // With this share of the way from its dilation to its friction: at 1 there is a potential.
    MohrCoulomb dilating(double share) const;
    ZonePoints points;                       // of tetrahedra only the number of components
    Eigen::MatrixXd elasticity, compliance;  // Pa, 1/Pa: of one point, its components
    Eigen::MatrixXd modes, strains;          // Z and D^-1 Z; rows components * point + component
  };
  struct Flow {
    std::size_t number;             // in Plasticity::zones()
    Eigen::VectorXd begin;          // strain at the begin, as Zone has it
    Eigen::VectorXd elastic;        // Pa, s
    Eigen::VectorXd modes, gained;  // x; d, components * point + component
  };
  static Law law_of(const Mesh& mesh, std::size_t solid);
  const Law& law(const Flow& flow) const {
    return laws_[static_cast<std::size_t>(plasticity_.zone(flow.number).solid)];
  }
  ZonePoints points(const Flow& flow) const {
    return plasticity_.points_of(plasticity_.zones()[flow.number]);
  }
  struct Search;
  bool seek(Flow& flow) const;

  const Mesh& mesh_;
  Plasticity& plasticity_;
  std::vector<Law> laws_;    // of each solid; empty matrices if it does not yield
  std::vector<Flow> flows_;  // ascending
  std::size_t lost_ = 0;
  Follow when_ = Follow::at_once;
};

}  // namespace trackbed::fem
