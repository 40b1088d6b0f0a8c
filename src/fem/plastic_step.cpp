// Plain matrices, zone by zone: only zones that flow come here.
//
// Z is found from R itself, by its eigenvectors: plane and space, and any enhanced strains, are one
// code. With E = D^-1 Z one has E^T D E = 1, E^T s = 0 and E^T S = 0, so the equilibrium of the
// enhanced strains, E^T sigma = 0, is x = Z^T d.
#include "plastic_step.hpp"

#include <algorithm>
#include <cmath>

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

// Seeks a share of a step at which `along`, which falls from 1 at 0 to below 0 at 1, has lost at
// least half: shares of all sizes first, then between the last two. Leaves the last one tried.
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
  Law law{elastic,
          mesh.solids.strength[solid],
          {elastic, mesh.solids.strength[solid]},
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

MohrCoulomb PlasticStep::Law::dilating(double share) const {
  Strength more = strength;
  more.dilation_angle += share * (strength.friction_angle - strength.dilation_angle);
  return {elastic, more};
}

// Newton on x - Z^T d(x), the enhanced strains of a zone.
struct PlasticStep::Search {
  // What is left lags as in explicit steps: the balance of the nodes holds without it, and as
  // stress beyond the strength it is the next step's to take up.
  static constexpr double little = 1e-4;
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
  Vector left() const { return flow.modes - law.modes.transpose() * at.gained; }
  bool is_below(double share) const {
    return left().norm() <= scale * (share * at.gained.norm() + rounding);
  }
  Vector step(const Matrix& slope, const Vector& open, double damping) const {
    const Matrix damped = slope + damping * Matrix::Identity(slope.rows(), slope.cols());
    return -damped.partialPivLu().solve(open);
  }
  Matrix slope() const { return law.strains.transpose() * by_points(at.slope, law.modes); }

  // For an associated law what is left is the gradient of a convex potential with curvatures from 0
  // to 1: 0 where enhanced strains only flow, along which a step ends far beyond the next border of
  // the strength. There it is cut to where the potential along it is least, found by the sign of
  // its slope.
  void go_along_steps() {
    constexpr double enough = 1e-12, damping = 1e-10;
    constexpr int most = 100;
    for (int k = 0; k < most && !is_below(enough); ++k) {
      const Vector open = left(), from = flow.modes, way = step(slope(), open, damping);
      const auto along = [&](double share) {  // slope of the potential, 1 at the begin
        move_to(from + share * way);
        return left().dot(way) / open.dot(way);
      };
      if (along(1) < 0 && left().norm() >= open.norm()) cut(along);
    }
  }

  // Without a potential steps are taken that get nearer, if need be with a share of the identity
  // added (Levenberg 1944, doi:10.1090/qam/10666).
  void go_damped() {
    constexpr double enough = 1e-10;
    constexpr int most = 30;
    for (int k = 0; k < most && !is_below(enough); ++k) {
      const Vector open = left(), from = flow.modes;
      const Matrix here = slope();
      for (const double damping : {1e-10, 1e-6, 1e-4, 1e-2, 0.1, 1.0}) {
        move_to(from + step(here, open, damping));
        if (left().norm() < open.norm()) break;
      }
    }
  }

  // With less dilation than friction there is no potential: steps along it may go in circles, and
  // what is left may have a least value that is no end. So the end with dilation = friction, where
  // there is one, is followed as dilation falls to what it is, in shares of the way that damped
  // steps manage (continuation: Allgower, Georg 1990, doi:10.1007/978-3-642-61257-2). Mostly four
  // are enough.
  void go_by_dilation() {
    constexpr double shortest = 1e-3;
    surface = law.dilating(1);
    move_to(Vector::Zero(flow.modes.size()));
    go_along_steps();
    for (double apart = 1, stride = 0.25; apart > 0 && stride > shortest;) {
      const Vector from = flow.modes;
      const double next = std::max(0.0, apart - stride);
      surface = law.dilating(next);
      move_to(from);
      go_damped();
      const bool there = is_below(little);
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

// Two ways, one after the other. Returns whether no more than a little is left.
bool PlasticStep::seek(Flow& flow) const {
  const Law& l = law(flow);
  if (l.modes.cols() == 0 || when_ == Follow::next_step) {
    flow.gained = bring_back(l.surface, l.points, flow.elastic, false).gained;
    return true;
  }
  Search search{l, flow};
  search.go_along_steps();
  if (!search.is_below(Search::little)) search.go_by_dilation();
  flow.gained = search.at.gained;
  return search.is_below(Search::little);
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
    if (l.modes.cols() > 0 && when_ == Follow::at_once) {
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

double PlasticStep::largest_strain() const {
  double most = 0;
  for (const Flow& flow : flows_) {
    const double* strain = plasticity_.zone(flow.number).strain;
    for (std::size_t k = 0; k < plasticity_.width(); ++k)
      most = std::max(most, std::abs(strain[k]));
  }
  return most;
}

double PlasticStep::largest_gain() const {
  double most = 0;
  for (const Flow& flow : flows_) most = std::max(most, flow.gained.cwiseAbs().maxCoeff());
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
    const Vector stress = trial - by_points(l.elasticity, flow.gained);
    *plasticity_.zone(flow.number).work += points(flow).weighted(stress).col(0).dot(flow.gained);
    if (l.modes.cols() > 0) continue;
    constexpr int parts = 6;  // of tetrahedra
    for (int g = 0; g < tetrahedron_points; ++g)
      if (!flow.gained.segment<parts>(parts * g).isZero(0) &&
          l.surface.opens(stress.segment<parts>(parts * g)))
        plasticity_.open(flow.number, u);
  }
  flows_.clear();
}

void PlasticStep::undo() {
  for (const Flow& flow : flows_)
    std::copy(flow.begin.begin(), flow.begin.end(), plasticity_.zone(flow.number).strain);
}

}  // namespace trackbed::fem
