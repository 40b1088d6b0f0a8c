// Output of yielding elements: stresses, strain, energies, and their state. Plain matrices, element
// by element: used for output only.
#include <cmath>

#include "fem/kernel/plasticity.hpp"

namespace trackbed::fem {

// Ordered as the matrices of ElementPoints: components * point + component.
Eigen::VectorXd Plasticity::strain(std::size_t number, When when) const {
  const Eigen::Index parts = mesh_.lattice.plane ? 4 : 6;
  const Eigen::Index points = static_cast<Eigen::Index>(width_) / parts;
  Eigen::VectorXd found(parts * points);
  for (Eigen::Index g = 0; g < points; ++g)
    for (Eigen::Index c = 0; c < parts; ++c) {
      const std::size_t at = number * width_ + static_cast<std::size_t>(c * points + g);
      found(parts * g + c) =
          when == When::static_ ? static_strain_[at] : strain_[at] - static_strain_[at];
    }
  return found;
}

// The elastic parts at the centre and at the middle of the top are the mean over the points, and
// the linear extrapolation through the means of the lower and the upper points, at z = 0 and 1 of
// an element from -1 to 1; the same holds here.
Vec6 Plasticity::stress(std::size_t element, Where where, When when) const {
  Vec6 sum = Vec6::Zero();
  if (number_[element] < 0) return sum;
  if (tetrahedra_ != nullptr) return stress_at(element, tetrahedron_centre(), when);
  const ElementPoints& points = law_of(element).points;
  const Eigen::VectorXd relief =
      points.relief * strain(static_cast<std::size_t>(number_[element]), when);
  const int parts = points.components, count = static_cast<int>(relief.size()) / parts;
  for (int g = 0; g < count; ++g) {
    const double up = 2 * g >= count ? 1 : -1;  // the last bit is z; points are at 1/sqrt(3)
    const double fraction = (1 + (where == Where::top ? std::sqrt(3.0) * up : 0)) / count;
    for (int c = 0; c < parts; ++c) sum(points.voigt(c)) += fraction * relief(parts * g + c);
  }
  return sum;
}

// Normalised to 1 for a plastic strain of 1 along an axis with -1/2 across.
double Plasticity::equivalent_strain(std::size_t element) const {
  if (number_[element] < 0) return 0;
  const auto number = static_cast<std::size_t>(number_[element]);
  const Eigen::VectorXd all = strain(number, When::static_) + strain(number, When::since);
  const ElementPoints& points = law_of(element).points;
  const int parts = points.components, count = static_cast<int>(all.size()) / parts;
  Vec6 mean = Vec6::Zero();
  for (int g = 0; g < count; ++g)
    for (int c = 0; c < parts; ++c) mean(points.voigt(c)) += all(parts * g + c) / count;
  mean.head<3>().array() -= mean.head<3>().sum() / 3;
  return std::sqrt(2.0 / 3 * (mean.head<3>().squaredNorm() + 0.5 * mean.tail<3>().squaredNorm()));
}

double Plasticity::dissipated(std::size_t element) const {
  return number_[element] < 0 ? 0 : work_[static_cast<std::size_t>(number_[element])];
}

std::vector<double> Plasticity::dissipated() const {
  std::vector<double> terms;
  for (std::size_t n = 0; n < element_.size(); ++n)
    if (mesh_.writes(element_[n])) terms.push_back(work_[n]);
  return terms;
}

// With e the plastic strain since static equilibrium and e0 that in it: the total elastic energy
// minus the static one and minus the work of the static reactions,
//   1/2 u K u - V e (S u + S u0 + R e0) - 1/2 V e R e;
// e S u0 is the work of the static stress on the plastic strain increment. The work of weight is
// counted separately.
std::vector<double> Plasticity::stored(const Nodal& u0, const Nodal& u) const {
  const int components = mesh_.lattice.components(), corners = mesh_.corners();
  std::vector<double> terms;
  for (std::size_t n = 0; n < element_.size(); ++n) {
    if (flowed_[n] == 0 || !mesh_.writes(element_[n])) continue;
    const ElementPoints points = points_of(element_[n]);
    Eigen::VectorXd motion(components * corners);
    for (int k = 0; k < corners; ++k)
      for (int c = 0; c < components; ++c) {
        const std::int32_t node = mesh_.corner(element_[n], k);
        motion(components * k + c) = u[c][node] + u0[c][node];
      }
    const Eigen::VectorXd since = strain(n, When::since);
    const Eigen::VectorXd stress =
        points.recovery * motion + points.relief * (strain(n, When::static_) + 0.5 * since);
    terms.push_back(-points.weighted(stress).col(0).dot(since));
    if (tetrahedra_ != nullptr && opened_[n] != 0) terms.push_back(-weight_work(n, u));
  }
  return terms;
}

void Plasticity::list(const Visit& visit) {
  visit("plastic/strain", "-",
        "total plastic strain, including that in static equilibrium: for each of xx, yy, zz, xy, "
        "yz, zx (plane: xx, yy, zz, zx; shear "
        "doubled) the values at all Gauss points",
        width_, strain_);
  visit("plastic/static", "-", "plastic strain in static equilibrium, in the same order", width_,
        static_strain_);
  visit("plastic/work", "J", "dissipated by yielding of the element", 1, work_);
  if (tetrahedra_ != nullptr)
    visit("plastic/opened", "-", "1 if the element has yielded in tension since static equilibrium",
          1, opened_);
}

}  // namespace trackbed::fem
