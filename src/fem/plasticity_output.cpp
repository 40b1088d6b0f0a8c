// What zones that yield show: stresses, strain, energies, and their state by name. Plain matrices,
// zone by zone: asked for output alone.
#include <cmath>

#include "plasticity.hpp"

namespace trackbed::fem {

// Ordered as the matrices of ZonePoints: components * point + component.
Eigen::VectorXd Plasticity::strain(std::size_t number, When when) const {
  const Eigen::Index parts = mesh_.lattice.plane ? 4 : 6;
  const Eigen::Index points = static_cast<Eigen::Index>(width_) / parts;
  Eigen::VectorXd found(parts * points);
  for (Eigen::Index g = 0; g < points; ++g)
    for (Eigen::Index c = 0; c < parts; ++c) {
      const std::size_t at = number * width_ + static_cast<std::size_t>(c * points + g);
      found(parts * g + c) = when == When::rest ? rest_[at] : strain_[at] - rest_[at];
    }
  return found;
}

// The elastic parts at the centre and amid the top are the mean over the points and the line
// through the means of the lower and the upper ones, at z = 0 and 1 of a zone from -1 to 1: so is
// this.
Vec6 Plasticity::stress(std::size_t zone, Where where, When when) const {
  Vec6 sum = Vec6::Zero();
  if (number_[zone] < 0) return sum;
  if (tetrahedra_ != nullptr) return stress_at(zone, tetrahedron_centre(), when);
  const ZonePoints& points = law_of(zone).points;
  const Eigen::VectorXd relief =
      points.relief * strain(static_cast<std::size_t>(number_[zone]), when);
  const int parts = points.components, count = static_cast<int>(relief.size()) / parts;
  for (int g = 0; g < count; ++g) {
    const double up = 2 * g >= count ? 1 : -1;  // the last bit is z; points lie at 1/sqrt(3)
    const double share = (1 + (where == Where::top ? std::sqrt(3.0) * up : 0)) / count;
    for (int c = 0; c < parts; ++c) sum(points.voigt(c)) += share * relief(parts * g + c);
  }
  return sum;
}

// As in one-dimensional strain: 1 for a plastic strain of 1 along an axis with -1/2 across.
double Plasticity::sheared(std::size_t zone) const {
  if (number_[zone] < 0) return 0;
  const auto number = static_cast<std::size_t>(number_[zone]);
  const Eigen::VectorXd all = strain(number, When::rest) + strain(number, When::since);
  const ZonePoints& points = law_of(zone).points;
  const int parts = points.components, count = static_cast<int>(all.size()) / parts;
  Vec6 mean = Vec6::Zero();
  for (int g = 0; g < count; ++g)
    for (int c = 0; c < parts; ++c) mean(points.voigt(c)) += all(parts * g + c) / count;
  mean.head<3>().array() -= mean.head<3>().sum() / 3;
  return std::sqrt(2.0 / 3 * (mean.head<3>().squaredNorm() + 0.5 * mean.tail<3>().squaredNorm()));
}

double Plasticity::lost(std::size_t zone) const {
  return number_[zone] < 0 ? 0 : work_[static_cast<std::size_t>(number_[zone])];
}

std::vector<double> Plasticity::lost() const {
  std::vector<double> terms;
  for (std::size_t n = 0; n < zone_.size(); ++n)
    if (mesh_.writes(zone_[n])) terms.push_back(work_[n]);
  return terms;
}

// With e the plastic strain since rest, e0 that at rest: the elastic energy of all less that at
// rest and the work of what held the rest,
//   1/2 u K u - V e (S u + S rest + R e0) - 1/2 V e R e;
// e S rest is the work of the stress at rest on what flows. Weight that has moved has its own.
std::vector<double> Plasticity::stored(const Nodal& rest, const Nodal& u) const {
  const int components = mesh_.lattice.components(), corners = mesh_.corners();
  std::vector<double> terms;
  for (std::size_t n = 0; n < zone_.size(); ++n) {
    if (flowed_[n] == 0 || !mesh_.writes(zone_[n])) continue;
    const ZonePoints points = points_of(zone_[n]);
    Eigen::VectorXd motion(components * corners);
    for (int k = 0; k < corners; ++k)
      for (int c = 0; c < components; ++c) {
        const std::int32_t node = mesh_.corner(zone_[n], k);
        motion(components * k + c) = u[c][node] + rest[c][node];
      }
    const Eigen::VectorXd since = strain(n, When::since);
    const Eigen::VectorXd stress =
        points.recovery * motion + points.relief * (strain(n, When::rest) + 0.5 * since);
    terms.push_back(-points.weighted(stress).col(0).dot(since));
    if (tetrahedra_ != nullptr && opened_[n] != 0) terms.push_back(-sag(n, u));
  }
  return terms;
}

void Plasticity::list(const Visit& visit) {
  visit("plastic/strain", "-", "all plastic strain at the Gauss points, component by component",
        width_, strain_);
  visit("plastic/rest", "-", "that in the state of rest", width_, rest_);
  visit("plastic/work", "J", "lost by yielding of the zone", 1, work_);
  if (tetrahedra_ != nullptr)
    visit("plastic/opened", "-", "1 if the zone has opened since rest", 1, opened_);
}

}  // namespace trackbed::fem
