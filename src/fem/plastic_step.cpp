// Plain matrices, zone by zone: only zones that flow come here.
//
// Z is found from R itself, by its eigenvectors: plane and space, and any enhanced strains, are one
// code. With E = D^-1 Z one has E^T D E = 1, E^T s = 0 and E^T S = 0, so the equilibrium of the
// enhanced strains, E^T sigma = 0, is x = Z^T d.
#include "plastic_step.hpp"

#include "tetrahedron.hpp"

namespace trackbed::fem {

namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

// Returned stress, what flowed and, if asked for, the slopes of all points.
struct Returned {
  Vector stress, gained;
  Matrix slope;  // of each point below the other: components columns
};

Returned bring_back(const MohrCoulomb& surface, const ZonePoints& points, const Vector& trial,
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
      found.gained(parts * g + c) = plastic(points.voigt(c));
      if (!with_slope) continue;
      for (int d = 0; d < parts; ++d)
        found.slope(parts * g + c, d) = slope(points.voigt(c), points.voigt(d));
    }
  }
  return found;
}

// Each point's rows by its own matrix.
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
  Law law{{elastic, mesh.solids.strength[solid]},
          mesh.imported ? ZonePoints{} : zone_points(mesh.solids.size[solid], elastic, dimension),
          {},
          {},
          {},
          {}};
  if (mesh.solids.strength[solid].yield == Yield::none) return law;
  const ZonePoints& points = law.points;
  const int parts = points.components;
  const Voigt all = elasticity(elastic);
  law.elasticity.resize(parts, parts);
  for (int c = 0; c < parts; ++c)
    for (int d = 0; d < parts; ++d) law.elasticity(c, d) = all(points.voigt(c), points.voigt(d));
  law.compliance = law.elasticity.inverse();
  if (mesh.imported) {  // no enhanced strains
    law.modes = law.strains = Matrix(parts * tetrahedron_points, 0);
    return law;
  }
  // R + D, symmetric as all points have one volume.
  Matrix square = points.relief;
  for (Eigen::Index g = 0; g < square.rows() / parts; ++g)
    square.block(parts * g, parts * g, parts, parts) += law.elasticity;
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(0.5 * (square + square.transpose()));
  const Vector& size = solver.eigenvalues();  // smallest first
  const double least = 1e-9 * size.maxCoeff();
  const Eigen::Index rank = (size.array() > least).count();
  law.modes = solver.eigenvectors().rightCols(rank) * size.tail(rank).cwiseSqrt().asDiagonal();
  law.strains = by_points(law.compliance, law.modes);
  return law;
}

PlasticStep::PlasticStep(const Mesh& mesh, Plasticity& plasticity)
    : mesh_(mesh), plasticity_(plasticity) {
  for (std::size_t s = 0; s < mesh.solids.solid.size(); ++s) laws_.push_back(law_of(mesh, s));
}

// Newton on x - Z^T d(x), damped where that does not get nearer: by a share of the identity
// (Levenberg 1944, doi:10.1090/qam/10666), since enhanced strains that only flow have no stiffness
// at all. For an associated law x - Z^T d is the gradient of a convex potential with curvatures
// from 0 to 1, so the most damped step gets nearer. A little of what is left after `most` lags as
// in explicit steps: the balance of the nodes holds without it. Returns whether no more is left.
bool PlasticStep::seek(Flow& flow) const {
  constexpr int most = 100;
  constexpr double little = 1e-6;
  constexpr double enough = 1e-12, rounding = 1e-15;
  constexpr std::array damping = {1e-10, 1e-6, 1e-4, 1e-2, 0.1, 1.0};
  const Law& l = law(flow);
  if (l.modes.cols() == 0) {
    flow.gained = bring_back(l.surface, l.points, flow.elastic, false).gained;
    return true;
  }
  const double scale = l.modes.cwiseAbs().maxCoeff();
  const double least = rounding * flow.elastic.norm() / l.elasticity(0, 0);
  const auto evaluate = [&](const Vector& modes) {
    return bring_back(l.surface, l.points, flow.elastic + l.modes * modes, true);
  };
  Returned at = evaluate(flow.modes);
  for (int k = 0; k < most; ++k) {
    const Vector open = flow.modes - l.modes.transpose() * at.gained, from = flow.modes;
    if (open.norm() <= scale * (enough * at.gained.norm() + least)) break;
    const Matrix slope = l.strains.transpose() * by_points(at.slope, l.modes);
    for (const double more : damping) {
      const Matrix damped = slope + more * Matrix::Identity(slope.rows(), slope.cols());
      flow.modes = from - damped.partialPivLu().solve(open);
      at = evaluate(flow.modes);
      if ((flow.modes - l.modes.transpose() * at.gained).norm() < open.norm()) break;
    }
  }
  flow.gained = at.gained;
  const double open = (flow.modes - l.modes.transpose() * at.gained).norm();
  return open <= scale * (little * at.gained.norm() + least);
}

// Enhanced strains are sought from none: those of the last try may have been far off, and from
// there without dilation another end may be met, with plastic work out of nothing.
void PlasticStep::flow(const Nodal& rest, const Nodal& u) {
  undo();
  flows_.clear();
  const auto width = static_cast<Eigen::Index>(plasticity_.width());
  plasticity_.beyond(rest, u, [&](std::size_t number, const double* stress) {
    Flow flow{number,
              Eigen::Map<const Vector>(plasticity_.zone(number).strain, width),
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
  lost_ = 0;
  for (Flow& flow : flows_) {
    if (!seek(flow)) ++lost_;
    const Plasticity::Zone zone = plasticity_.zone(flow.number);
    const Eigen::Index parts = law(flow).points.components, count = width / parts;
    for (Eigen::Index g = 0; g < count; ++g)
      for (Eigen::Index c = 0; c < parts; ++c)
        zone.strain[c * count + g] += flow.gained(parts * g + c);
    *zone.flowed = 1;
  }
}

// With T the slopes of the points: dsigma = T (S du + Z dx), E^T dsigma = 0, df = V S^T D^-1
// dsigma.
void PlasticStep::tangent(const Visit& visit) const {
  for (const Flow& flow : flows_) {
    const Law& l = law(flow);
    const Returned at = bring_back(l.surface, l.points, flow.elastic + l.modes * flow.modes, true);
    const ZonePoints of = points(flow);
    Matrix stress = by_points(at.slope, of.recovery);
    if (l.modes.cols() > 0) {
      const Matrix of_modes = by_points(at.slope, l.modes);
      const Matrix slope = l.strains.transpose() * of_modes;
      // At an apex nothing resists some of the enhanced strains: least norm.
      const Matrix follow =
          slope.completeOrthogonalDecomposition().solve(l.strains.transpose() * stress);
      stress.noalias() -= of_modes * follow;
    }
    const Matrix force = of.weighted(by_points(l.compliance, of.recovery)).transpose();
    visit(plasticity_.zones()[flow.number], force * (stress - of.recovery));
  }
}

void PlasticStep::keep() {
  for (const Flow& flow : flows_) {
    const Law& l = law(flow);
    const Vector trial = flow.elastic + l.modes * flow.modes;
    const Vector stress = trial - by_points(l.elasticity, flow.gained);
    *plasticity_.zone(flow.number).work += points(flow).weighted(stress).col(0).dot(flow.gained);
  }
  flows_.clear();
}

void PlasticStep::undo() {
  for (const Flow& flow : flows_)
    std::copy(flow.begin.begin(), flow.begin.end(), plasticity_.zone(flow.number).strain);
}

}  // namespace trackbed::fem
