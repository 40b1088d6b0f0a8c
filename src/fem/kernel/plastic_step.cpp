// Plain matrices, element by element: only yielding elements are computed here.
//
// Z is computed from R by its eigenvectors: plane and space, and any enhanced strains, share the
// code. With E = D^-1 Z one has E^T D E = 1, E^T s = 0 and E^T S = 0, so the equilibrium of the
// enhanced strains, E^T sigma = 0, is x = Z^T d.
#include "fem/kernel/plastic_step.hpp"

#include <algorithm>
#include <cmath>

#include "fem/shape/tetrahedron.hpp"
#include "trackbed/core/decompositions.hpp"

namespace trackbed::fem {

namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

// Returned stress, plastic strain increment and, if requested, the tangents of all points.
struct Returned {
  Vector stress, increment;
  Matrix slope;  // of all points, one below the other: components columns
};

Returned bring_back(const MohrCoulomb& surface, const ElementPoints& points, const Vector& trial,
                    bool with_slope) {
  const int parts = points.components, count = static_cast<int>(trial.size()) / parts;
  Returned found{trial, Vector::Zero(trial.size()), {}};
  if (with_slope) found.slope.resize(trial.size(), parts);
  for (int g = 0; g < count; ++g) {
    Vec6 stress = Vec6::Zero(), plastic = Vec6::Zero();
    Voigt slope = Voigt::Identity();
    for (int c = 0; c < parts; ++c) stress(points.voigt(c)) = trial(parts * g + c);
    surface.bring_back(stress, plastic, with_slope ? &slope : nullptr);
    for (int c = 0; c < parts; ++c) {
      found.stress(parts * g + c) = stress(points.voigt(c));
      found.increment(parts * g + c) = plastic(points.voigt(c));
      if (!with_slope) continue;
      for (int d = 0; d < parts; ++d)
        found.slope(parts * g + c, d) = slope(points.voigt(c), points.voigt(d));
    }
  }
  return found;
}

// Finds a fraction of a step at which `along`, which decreases from 1 at 0 to below 0 at 1, is
// within +-1/2: first over all orders of magnitude, then between the last two. Ends with the last
// fraction tried.
template <class Along>
void cut(const Along& along) {
  constexpr int most = 100;
  double low = 1e-14, high = 1, at_low = 1, at_high = -1;
  for (int k = 0; k < most; ++k) {
    const bool far = high > 4 * low;
    const double middle = far     ? std::sqrt(low * high)
                          : k % 2 ? 0.5 * (low + high)
                                  : low + (high - low) * at_low / (at_low - at_high);
    const double found = along(middle);
    if (std::abs(found) <= 0.5) return;
    (found > 0 ? low : high) = middle;
    (found > 0 ? at_low : at_high) = found;
  }
}

// Multiplies the rows of each point by its own matrix.
Matrix by_points(const Matrix& of_points, const Matrix& rows) {
  const Eigen::Index parts = of_points.cols(), count = rows.rows() / parts;
  Matrix found(rows.rows(), rows.cols());
  for (Eigen::Index g = 0; g < count; ++g)
    found.middleRows(parts * g, parts).noalias() =
        of_points.middleRows(of_points.rows() > parts ? parts * g : 0, parts) *
        rows.middleRows(parts * g, parts);
  return found;
}

}  // namespace

PlasticStep::Law PlasticStep::law_of(const Mesh& mesh, std::size_t solid) {
  const Dimension dimension = mesh.lattice.plane ? Dimension::plane : Dimension::space;
  const Elastic& elastic = mesh.solids.solid[solid];
  Law law{
      elastic,
      mesh.solids.strength[solid],
      {elastic, mesh.solids.strength[solid]},
      mesh.imported ? ElementPoints{} : element_points(mesh.solids.size[solid], elastic, dimension),
      {},
      {},
      {},
      {}};
  if (mesh.solids.strength[solid].yield == Yield::none) return law;
  const ElementPoints& points = law.points;
  const int parts = points.components;
  const Voigt all = elasticity(elastic);
  law.elasticity.resize(parts, parts);
  for (int c = 0; c < parts; ++c)
    for (int d = 0; d < parts; ++d) law.elasticity(c, d) = all(points.voigt(c), points.voigt(d));
  law.compliance = solutions(law.elasticity, Matrix::Identity(parts, parts));
  if (mesh.imported) {  // no enhanced strains
    law.modes = law.strains = Matrix(parts * tetrahedron_points, 0);
    return law;
  }
  // R + D, symmetric as all points have the same volume.
  Matrix square = points.relief;
  for (Eigen::Index g = 0; g < square.rows() / parts; ++g)
    square.block(parts * g, parts * g, parts, parts) += law.elasticity;
  const auto [size, vectors] = symmetric_modes(0.5 * (square + square.transpose()));  // ascending
  const double least = 1e-9 * size.maxCoeff();
  const Eigen::Index rank = (size.array() > least).count();
  law.modes = vectors.rightCols(rank) * size.tail(rank).cwiseSqrt().asDiagonal();
  law.strains = by_points(law.compliance, law.modes);
  return law;
}

MohrCoulomb PlasticStep::Law::dilating(double fraction) const {
  Strength more = strength;
  more.dilation_angle += fraction * (strength.friction_angle - strength.dilation_angle);
  return {elastic, more};
}

// Newton's method for x - Z^T d(x) = 0, the enhanced strains of an element.
struct PlasticStep::Search {
  // A residual below this lags as in explicit steps: nodal equilibrium does not depend on it, and
  // as stress beyond the strength it is corrected in the next step.
  static constexpr double accepted = 1e-4;
  const Law& law;
  Flow& flow;
  MohrCoulomb surface = law.surface;
  Returned at = evaluate();
  double scale = law.modes.cwiseAbs().maxCoeff();
  double rounding = 1e-15 * flow.elastic.norm() / law.elasticity(0, 0);

  Returned evaluate() const {
    return bring_back(surface, law.points, flow.elastic + law.modes * flow.modes, true);
  }
  void move_to(const Vector& modes) {
    flow.modes = modes;
    at = evaluate();
  }
  Vector residual() const { return flow.modes - law.modes.transpose() * at.increment; }
  bool is_below(double fraction) const {
    return residual().norm() <= scale * (fraction * at.increment.norm() + rounding);
  }
  Vector step(const Matrix& slope, const Vector& initial, double damping) const {
    const Matrix damped = slope + damping * Matrix::Identity(slope.rows(), slope.cols());
    return -solution(damped, initial);
  }
  Matrix slope() const { return law.strains.transpose() * by_points(at.slope, law.modes); }

  // For an associated law the residual is the gradient of a convex potential with curvatures from 0
  // to 1: 0 where enhanced strains are purely plastic, in whose directions a step ends far beyond
  // the next corner of the yield surface. There the step is cut to the minimum of the potential
  // along it, found from the sign of its slope.
  void solve_associated() {
    constexpr double enough = 1e-12, damping = 1e-10;
    constexpr int most = 100;
    for (int k = 0; k < most && !is_below(enough); ++k) {
      const Vector initial = residual(), from = flow.modes,
                   direction = step(slope(), initial, damping);
      const auto along = [&](double fraction) {  // slope of the potential, 1 at the begin
        move_to(from + fraction * direction);
        return residual().dot(direction) / initial.dot(direction);
      };
      if (along(1) < 0 && residual().norm() >= initial.norm()) cut(along);
    }
  }

  // Without a potential, steps must reduce the residual, if necessary with a multiple of the
  // identity added (Levenberg 1944, doi:10.1090/qam/10666).
  void solve_damped() {
    constexpr double enough = 1e-10;
    constexpr int most = 30;
    for (int k = 0; k < most && !is_below(enough); ++k) {
      const Vector initial = residual(), from = flow.modes;
      const Matrix here = slope();
      for (const double damping : {1e-10, 1e-6, 1e-4, 1e-2, 0.1, 1.0}) {
        move_to(from + step(here, initial, damping));
        if (residual().norm() < initial.norm()) break;
      }
    }
  }

  // With less dilation than friction there is no potential: steps along it may cycle, and the
  // residual may have a minimum that is no solution. So the solution with dilation = friction, if
  // there is one, is followed while dilation decreases to its value, in increments for which damped
  // steps converge (continuation: Allgower, Georg 1990, doi:10.1007/978-3-642-61257-2). Mostly four
  // increments are enough.
  void solve_by_continuation() {
    constexpr double shortest = 1e-3;
    surface = law.dilating(1);
    move_to(Vector::Zero(flow.modes.size()));
    solve_associated();
    for (double apart = 1, stride = 0.25; apart > 0 && stride > shortest;) {
      const Vector from = flow.modes;
      const double next = std::max(0.0, apart - stride);
      surface = law.dilating(next);
      move_to(from);
      solve_damped();
      const bool there = is_below(accepted);
      if (!there) flow.modes = from;
      apart = there ? next : apart;
      stride *= there ? 2 : 0.5;
    }
    surface = law.surface;
    move_to(flow.modes);
  }
};

PlasticStep::PlasticStep(const Mesh& mesh, Plasticity& plasticity)
    : mesh_(mesh), plasticity_(plasticity) {
  for (std::size_t s = 0; s < mesh.solids.solid.size(); ++s) laws_.push_back(law_of(mesh, s));
}

// Two methods, one after the other. Returns whether the residual is acceptable.
bool PlasticStep::solve(Flow& flow) const {
  const Law& l = law(flow);
  if (l.modes.cols() == 0 || when_ == Follow::next_step) {
    flow.increment = bring_back(l.surface, l.points, flow.elastic, false).increment;
    return true;
  }
  Search search{l, flow};
  search.solve_associated();
  if (!search.is_below(Search::accepted)) search.solve_by_continuation();
  flow.increment = search.at.increment;
  return search.is_below(Search::accepted);
}

// The search starts from zero enhanced strains: those of the last trial may be far off, and from
// there, without dilation, another solution may be found, with spurious plastic work.
void PlasticStep::flow(const Nodal& u0, const Nodal& u) {
  undo();
  flows_.clear();
  const auto width = static_cast<Eigen::Index>(plasticity_.width());
  plasticity_.beyond(u0, u, [&](std::size_t number, const double* stress) {
    Flow flow{number,
              Eigen::Map<const Vector>(plasticity_.element(number).strain, width),
              Vector(width),
              {},
              {}};
    const Law& l = law(flow);
    const Eigen::Index parts = l.points.components, count = width / parts;
    for (Eigen::Index g = 0; g < count; ++g)
      for (Eigen::Index c = 0; c < parts; ++c) flow.elastic(parts * g + c) = stress[c * count + g];
    flow.modes = Vector::Zero(l.modes.cols());
    flows_.push_back(std::move(flow));
  });
  unsolved_ = 0;
  for (Flow& flow : flows_) {
    if (!solve(flow)) ++unsolved_;
    const Plasticity::Element element = plasticity_.element(flow.number);
    const Eigen::Index parts = law(flow).points.components, count = width / parts;
    for (Eigen::Index g = 0; g < count; ++g)
      for (Eigen::Index c = 0; c < parts; ++c)
        element.strain[c * count + g] += flow.increment(parts * g + c);
    *element.flowed = 1;
  }
}

// With T the tangents of the points: dsigma = T (S du + Z dx), E^T dsigma = 0, df = V S^T D^-1
// dsigma.
void PlasticStep::tangent(const Visit& visit) const {
  for (const Flow& flow : flows_) {
    const Law& l = law(flow);
    const Returned at = bring_back(l.surface, l.points, flow.elastic + l.modes * flow.modes, true);
    const ElementPoints of = points(flow);
    Matrix stress = by_points(at.slope, of.recovery);
    if (l.modes.cols() > 0 && when_ == Follow::at_once) {
      const Matrix of_modes = by_points(at.slope, l.modes);
      const Matrix slope = l.strains.transpose() * of_modes;
      // At an apex some enhanced strains have no resistance: least norm.
      const Matrix follow = least_norm_solutions(slope, l.strains.transpose() * stress);
      stress.noalias() -= of_modes * follow;
    }
    const Matrix force = of.weighted(by_points(l.compliance, of.recovery)).transpose();
    visit(plasticity_.elements()[flow.number], force * (stress - of.recovery));
  }
}

double PlasticStep::largest_strain() const {
  double most = 0;
  for (const Flow& flow : flows_) {
    const double* strain = plasticity_.element(flow.number).strain;
    for (std::size_t k = 0; k < plasticity_.width(); ++k)
      most = std::max(most, std::abs(strain[k]));
  }
  return most;
}

double PlasticStep::largest_increment() const {
  double most = 0;
  for (const Flow& flow : flows_) most = std::max(most, flow.increment.cwiseAbs().maxCoeff());
  return most;
}

bool PlasticStep::has_potential() const {
  return std::none_of(laws_.begin(), laws_.end(), [](const Law& law) {
    return law.modes.cols() > 0 && law.strength.dilation_angle < law.strength.friction_angle;
  });
}

void PlasticStep::keep(const Nodal& u) {
  for (const Flow& flow : flows_) {
    const Law& l = law(flow);
    const Vector trial = flow.elastic + l.modes * flow.modes;
    const Vector stress = trial - by_points(l.elasticity, flow.increment);
    *plasticity_.element(flow.number).work +=
        points(flow).weighted(stress).col(0).dot(flow.increment);
    if (l.modes.cols() > 0) continue;
    constexpr int parts = 6;  // of tetrahedra
    for (int g = 0; g < tetrahedron_points; ++g)
      if (!flow.increment.segment<parts>(parts * g).isZero(0) &&
          l.surface.opens(stress.segment<parts>(parts * g)))
        plasticity_.open(flow.number, u);
  }
  flows_.clear();
}

void PlasticStep::undo() {
  for (const Flow& flow : flows_)
    std::copy(flow.begin.begin(), flow.begin.end(), plasticity_.element(flow.number).strain);
}

}  // namespace trackbed::fem
