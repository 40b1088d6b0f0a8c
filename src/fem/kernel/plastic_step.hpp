// Yielding elements in an implicit step: plastic strain at its end from that at its begin, and the
// consistent tangent.
//
// Backward Euler with the enhanced strains in equilibrium, element by element. With e the plastic
// strain, d its increment, S and R those of Plasticity, R + D = Z Z^T of rank m (12 in space),
//   sigma = return(s + Z x),  s = S u + R e_begin,  d = D^-1 (s + Z x - sigma),  x = Z^T d:
// m equations for the enhanced strains x of an element, solved by Newton's method. The tangent is
// consistent (Simo, Taylor 1985, doi:10.1016/0045-7825(85)90070-2), the derivative of what is
// computed, so that Newton's method for the nodes converges quadratically. Unlike in explicit steps
// nothing lags, except with Follow::next_step.
//
// The class has no state of the run: only the plastic strain is kept after a step. Cost per
// yielding element: some 20 us a call, and for others the test of Plasticity. Rejected: enhanced
// strains that lag from iteration to iteration (linear convergence), or as global unknowns (half as
// many again).
#pragma once

#include <functional>
#include <vector>

#include "fem/kernel/plasticity.hpp"

namespace trackbed::fem {

class PlasticStep {
 public:
  // Both must outlive it.
  PlasticStep(const Mesh& mesh, Plasticity& plasticity);

  // Plastic strain at the end of the step under the motion u0 + u, independent of earlier trials
  // in this step. Ghosts must be current. Local.
  void flow(const Nodal& u0, const Nodal& u);
  // Whether enhanced strains follow the plastic strain increment of this step at once, or only in
  // the next step, as in explicit steps.
  enum class Follow { at_once, next_step };
  void follow(Follow when) { when_ = when; }
  // Number of held elements that yield at the last trial motion.
  std::size_t flowing() const { return flows_.size(); }
  // Number of held elements whose enhanced strains did not converge at the last trial motion: their
  // stress is not compatible with their strain, so a step must not end there.
  std::size_t unsolved() const { return unsolved_; }
  // The largest component of plastic strain in held elements that yield, and of its increment in
  // this motion.
  double largest_strain() const;
  double largest_increment() const;
  // Whether the enhanced strains of all solids have a potential: dilation equals friction.
  bool has_potential() const;
  // Calls visit(local element, N/m) with the change of the elastic stiffness due to yielding:
  // degrees of freedom as in ElementMatrices, symmetric only if dilation equals friction.
  using Visit = std::function<void(std::size_t, const Eigen::MatrixXd&)>;
  void tangent(const Visit& visit) const;
  // Accepts the last trial motion, u relative to static equilibrium, as the end of the step: keeps
  // its strain, adds its work, and marks tetrahedra that have opened.
  void keep(const Nodal& u);
  // Restores the strain at the begin of the step.
  void undo();

 private:
  struct Law {
    Elastic elastic;
    Strength strength;
    MohrCoulomb surface;
    // The law with dilation moved by this fraction towards friction: at 1 there is a potential.
    MohrCoulomb dilating(double fraction) const;
    ElementPoints points;                    // for tetrahedra only the number of components
    Eigen::MatrixXd elasticity, compliance;  // Pa, 1/Pa: of one point, its components
    Eigen::MatrixXd modes, strains;          // Z and D^-1 Z; rows components * point + component
  };
  struct Flow {
    std::size_t number;                // in Plasticity::elements()
    Eigen::VectorXd begin;             // strain at the begin, in the order of Element
    Eigen::VectorXd elastic;           // Pa, s
    Eigen::VectorXd modes, increment;  // x; d, components * point + component
  };
  static Law law_of(const Mesh& mesh, std::size_t solid);
  const Law& law(const Flow& flow) const {
    return laws_[static_cast<std::size_t>(plasticity_.element(flow.number).solid)];
  }
  ElementPoints points(const Flow& flow) const {
    return plasticity_.points_of(plasticity_.elements()[flow.number]);
  }
  struct Search;
  bool solve(Flow& flow) const;

  const Mesh& mesh_;
  Plasticity& plasticity_;
  std::vector<Law> laws_;    // of each solid; empty matrices if it does not yield
  std::vector<Flow> flows_;  // ascending
  std::size_t unsolved_ = 0;
  Follow when_ = Follow::at_once;
};

}  // namespace trackbed::fem
