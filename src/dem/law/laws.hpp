// Conversion of the deck's declarations of pairs of materials to data of the kernels. The force
// law: contact.hpp.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "dem/lanes/vec4.hpp"
#include "dem/law/contact.hpp"
#include "trackbed/dem/law.hpp"

namespace trackbed::dem {

// One pair of materials, ready for the kernels, which do not distinguish kinds of laws; each kind
// is converted in laws.cpp (`law_of`).
struct Law {
  Springs<double> springs;
  Rolling<double> rolling;
};

// m, overlap at which the normal spring has this force (N): F ~ delta^1.5 or delta.
inline double overlap_at(const Law& law, double force, double radius) {
  const double at_one = coefficients<true>(law.springs, 1.0, 0.0, radius).k_n;
  return law.springs.hertz > 0 ? std::cbrt(force / at_one) * std::cbrt(force / at_one)
                               : force / at_one;
}

// Elastic energy stored in a contact, J: the integral of the normal force over delta, plus the
// tangential spring, xi m.
inline double stored_energy(const Law& law, double delta, double radius, const Vec4& xi) {
  const auto c = coefficients<true>(law.springs, delta, 0.0, radius);
  const double factor = law.springs.hertz > 0 ? 0.4 : 0.5;  // of F delta: F ~ delta^1.5 or delta
  return factor * c.k_n * delta * delta + 0.5 * c.k_s * (xi.x * xi.x + xi.y * xi.y + xi.z * xi.z);
}

// The energy in its rolling resistance, J.
inline double rolling_energy(const Law& law, double delta, double radius, const Vec4& roll) {
  const double k = law.rolling.stiffness * coefficients<true>(law.springs, delta, 0.0, radius).k_n;
  return 0.5 * k * (roll.x * roll.x + roll.y * roll.y + roll.z * roll.z);
}

// The laws of eight contacts.
struct alignas(64) LawLanes {
  double k_n[lanes], k_s[lanes], c_n[lanes], c_s[lanes], mu[lanes], least[lanes], hertz[lanes];
  void set(std::size_t k, const Law& law) {
    const Springs<double>& s = law.springs;
    k_n[k] = s.k_n, k_s[k] = s.k_s, c_n[k] = s.c_n, c_s[k] = s.c_s;
    mu[k] = s.mu, least[k] = s.least, hertz[k] = s.hertz;
  }
  [[gnu::always_inline]] Springs<Lanes> get() const {
    return {load(k_n), load(k_s), load(c_n), load(c_s), load(mu), load(least), load(hertz)};
  }
};

// Their rolling resistance; filled only if any law has one.
struct alignas(64) RollingLanes {
  double mu[lanes], stiffness[lanes], zeta[lanes];
  void set(std::size_t k, const Rolling<double>& law) {
    mu[k] = law.mu, stiffness[k] = law.stiffness, zeta[k] = law.zeta;
  }
  [[gnu::always_inline]] Rolling<Lanes> get() const {
    return {load(mu), load(stiffness), load(zeta)};
  }
};

// An entry of the neighbour list has a byte for its law (pairs.hpp).
inline constexpr std::size_t most_laws = 256;

// Laws of all pairs of materials, from the deck's declarations. Throws InputError for a pair given
// twice or an unknown material; `index` is -1 for a pair that is not given.
class LawTable {
 public:
  explicit LawTable(const Physics& physics);
  // Symmetric: a law applies to two materials in either order.
  int index(int material_i, int material_j) const {
    return pair_[static_cast<std::size_t>(material_i) * materials_ +
                 static_cast<std::size_t>(material_j)];  // -1: not declared
  }
  const Law& operator[](std::size_t index) const { return laws_[index]; }
  // `mu` is the friction of every law from now on; below 0: restores their own values.
  void override_friction(double mu);
  void scale_friction(double factor);  // of the given values
  // Stiffness and dampers of these laws, which are the same but for their stiffness.
  void set_stiffness(const Physics& physics);
  const std::vector<Law>& all() const { return laws_; }
  std::size_t materials() const { return materials_; }
  bool any_hertz() const {
    return std::any_of(laws_.begin(), laws_.end(),
                       [](const Law& law) { return law.springs.hertz > 0; });
  }
  bool any_rolls() const { return rolls_; }

 private:
  std::size_t materials_;
  bool rolls_ = false;
  std::vector<Law> laws_;
  std::vector<double> friction_;  // mu of each law as declared
  std::vector<int> pair_;
};

// Damping of a collision with the required restitution e in (0, 1]; `cut`: without attraction. beta
// of Tsuji's form (Hertz), the ratio of critical damping zeta (linear).
double hertz_damping(double restitution, bool cut);
double linear_damping(double restitution, bool cut);

}  // namespace trackbed::dem
