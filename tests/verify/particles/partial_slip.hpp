// Tangential force of a sphere on a plane with partial slip of the contact: reference solutions of
// the verification tests; in the program's law the whole contact sticks or slides.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace trackbed::slip {

// 1/E* and 1/G* as in laws.cpp: k_n = 4/3 E* a, k_s = 8 G* a.
struct Sphere {
  double radius, e_star, g_star, mu;
  double size(double overlap) const { return std::sqrt(radius * overlap); }
  double normal(double overlap) const { return 4.0 / 3.0 * e_star * size(overlap) * overlap; }
  double shear(double overlap) const { return 8 * g_star * size(overlap); }
  // Displacement at which the whole contact slips (Mindlin, Deresiewicz 1953,
  // doi:10.1115/1.4010702), and at which the spring without partial slip reaches the limit.
  double gross(double overlap) const { return mu * e_star * overlap / (4 * g_star); }
  double limit(double overlap) const { return mu * normal(overlap) / shear(overlap); }
};

// Mindlin, Deresiewicz: force over mu N, constant normal force, displacement x over `gross`. A
// branch after a reversal is the first one at twice the scale.
inline double first_loading(double x) { return 1 - std::pow(std::max(1 - x, 0.0), 1.5); }
// Work of a closed loop of this amplitude, over mu N gross.
inline double loop_work(double x) {
  const double below = std::min(x, 1.0);
  const double area = below - 0.4 * (1 - std::pow(1 - below, 2.5));
  return 8 * area - 4 * below * first_loading(below) + 4 * (x - below);
}

// Any history of overlap and slip: parallel springs, each with the Coulomb limit of its own normal
// force, which give the forces of the sphere exactly (method of dimensionality reduction: Popov,
// Hess 2015, Method of Dimensionality Reduction in Contact Mechanics and Friction,
// doi:10.1007/978-3-642-53876-6; for oblique impacts: Lyashenko, Popov 2015,
// doi:10.1038/srep08479). At a distance x from the middle the height of the sphere is x^2/R, the
// stiffnesses per length are E* and 4 G*; both sides are counted.
class Springs {
 public:
  Springs(const Sphere& sphere, double deepest, int count)
      : sphere_(sphere), width_(sphere.size(deepest) / count), force_(count) {}
  // Adds the displacement `slip` at this overlap; returns the tangential force against the slip.
  double move(double overlap, double slip) {
    double sum = 0;
    for (std::size_t k = 0; k < force_.size(); ++k) {
      const double x = (static_cast<double>(k) + 0.5) * width_;
      const double depth = std::max(overlap - x * x / sphere_.radius, 0.0);
      const double limit = sphere_.mu * 2 * sphere_.e_star * width_ * depth;
      force_[k] = std::clamp(force_[k] + 8 * sphere_.g_star * width_ * slip, -limit, limit);
      sum += force_[k];
    }
    return sum;
  }

 private:
  Sphere sphere_;
  double width_;
  std::vector<double> force_;
};

}  // namespace trackbed::slip
