// What a contact does, as pure functions of overlap, velocities, history and parameters.
//
// linear: F_n = k_n delta + c_n v_n, F_s = -k_s xi - c_s v_t, |F_s| <= mu F_n
//   (Cundall, Strack 1979, doi:10.1680/geot.1979.29.1.47), c = 2 zeta sqrt(m_eff k).
// hertz: k_n = 4/3 E* sqrt(R delta), k_s = 8 G* sqrt(R delta) (Mindlin 1949), damping
//   2 sqrt(5/6) beta sqrt(S m_eff), S = 2 E* sqrt(R delta) (Tsuji et al. 1992,
//   doi:10.1016/0032-5910(92)88030-L), beta found such that the collision, with no attraction,
//   has the wanted restitution.
// The tangential history xi stays in the tangent plane: projected on it, turned with the spin about
// the normal, and shortened when the force slips (the friction limit is applied in
// `contact_force`).
#pragma once

#include <algorithm>
#include <cmath>

#include "lanes.hpp"
#include "trackbed/dem/law.hpp"
#include "vec4.hpp"

namespace trackbed::dem {

// One pair of materials, ready for the kernels.
struct Law {
  LawKind kind = LawKind::linear;
  double least = 0;         // N, F_n >= least: 0 without attraction, else -infinity
  double k_n = 0, k_s = 0;  // N/m; hertz: 4/3 E* and 8 G*, Pa
  double c_n = 0, c_s = 0;  // over sqrt(m_eff): 2 zeta sqrt(k)
  double mu = 0;
};

// Stiffnesses and damping at one overlap.
struct Coefficients {
  double k_n, k_s, c_n, c_s, mu, least;
};

// R: 1/R = 1/R_i + 1/R_j (m); root_mass: sqrt of the effective mass. `hertz` false: all laws are
// linear, and the roots are left out.
template <bool hertz>
[[gnu::always_inline]] inline Coefficients coefficients(const Law& law, double delta,
                                                        double root_mass, double radius) {
  if constexpr (hertz) {
    const double a = law.kind == LawKind::linear ? 1.0 : std::sqrt(radius * delta);
    const double damping = std::sqrt(a) * root_mass;
    return {law.k_n * a, law.k_s * a, law.c_n * damping, law.c_s * damping, law.mu, law.least};
  }
  return {law.k_n, law.k_s, law.c_n * root_mass, law.c_s * root_mass, law.mu, law.least};
}

// Elastic energy stored in a contact, J.
inline double stored_energy(const Law& law, double delta, double radius, const Vec4& xi) {
  const Coefficients c = coefficients<true>(law, delta, 0, radius);
  const double share = law.kind == LawKind::linear ? 0.5 : 0.4;  // Hertz: 2/5 F delta
  return share * c.k_n * delta * delta + 0.5 * c.k_s * (xi.x * xi.x + xi.y * xi.y + xi.z * xi.z);
}

// What one contact is computed from: normal n from i to j (surface: into it), relative velocity v
// of i against j at the contact, twist = mean spin of the two about n.
struct Touch {
  double nx, ny, nz, vx, vy, vz, delta, twist;
};

// Force on i; moves the history xi by dt. The partner gets the opposite force. Selects instead of
// branches, so that the pair loop runs it on eight contacts at a time.
[[gnu::always_inline]] inline Vec4 contact_force(const Coefficients& c, const Touch& t, double dt,
                                                 Vec4& xi) {
  const double v_n = t.vx * t.nx + t.vy * t.ny + t.vz * t.nz;  // > 0: approaching
  const double free_n = c.k_n * t.delta + c.c_n * v_n;
  const double f_n = free_n > c.least ? free_n : c.least;
  const double vtx = t.vx - v_n * t.nx, vty = t.vy - v_n * t.ny, vtz = t.vz - v_n * t.nz;
  const double along = xi.x * t.nx + xi.y * t.ny + xi.z * t.nz;
  const double px = xi.x - along * t.nx, py = xi.y - along * t.ny, pz = xi.z - along * t.nz;
  const double turn = t.twist * dt;
  const double x = px + turn * (t.ny * pz - t.nz * py) + vtx * dt;
  const double y = py + turn * (t.nz * px - t.nx * pz) + vty * dt;
  const double z = pz + turn * (t.nx * py - t.ny * px) + vtz * dt;
  const double fx = -c.k_s * x - c.c_s * vtx, fy = -c.k_s * y - c.c_s * vty,
               fz = -c.k_s * z - c.c_s * vtz;
  // Coulomb's limit. When it acts, the history becomes the spring that carries exactly this force
  // (without a spring it has no use and is zero).
  const double limit = c.mu * (f_n > 0 ? f_n : 0.0);
  const double f2 = fx * fx + fy * fy + fz * fz;
  const bool slips = f2 > limit * limit;
  const double scale = slips ? limit / std::sqrt(f2) : 1.0;
  const double soft = c.k_s > 0 ? -1.0 / c.k_s : 0.0;
  const double sx = scale * fx, sy = scale * fy, sz = scale * fz;
  xi.x = slips ? soft * (sx + c.c_s * vtx) : x;
  xi.y = slips ? soft * (sy + c.c_s * vty) : y;
  xi.z = slips ? soft * (sz + c.c_s * vtz) : z;
  return {sx - f_n * t.nx, sy - f_n * t.ny, sz - f_n * t.nz, f_n};
}

// The laws of eight contacts, for loops over lanes.
struct alignas(64) LawLanes {
  double k_n[lanes], k_s[lanes], c_n[lanes], c_s[lanes], mu[lanes], least[lanes], hertz[lanes];
  void set(std::size_t k, const Law& law) {
    k_n[k] = law.k_n, k_s[k] = law.k_s, c_n[k] = law.c_n, c_s[k] = law.c_s;
    mu[k] = law.mu, least[k] = law.least;
    hertz[k] = law.kind == LawKind::hertz;
  }
  [[gnu::always_inline]] Law at(std::size_t k) const {
    return {hertz[k] > 0 ? LawKind::hertz : LawKind::linear,
            least[k],
            k_n[k],
            k_s[k],
            c_n[k],
            c_s[k],
            mu[k]};
  }
};

// Laws of all pairs of materials, from the deck's declarations. Throws InputError for a pair given
// twice or an unknown material; `index` is -1 for a pair that is not given.
class LawTable {
 public:
  explicit LawTable(const Physics& physics);
  int index(int material_i, int material_j) const {
    return pair_[static_cast<std::size_t>(material_i) * materials_ +
                 static_cast<std::size_t>(material_j)];  // -1: not declared
  }
  const Law& operator[](std::size_t index) const { return laws_[index]; }
  // `mu` is the friction of every law from now on; below 0: each has its own again.
  void override_friction(double mu);
  const std::vector<Law>& all() const { return laws_; }
  std::size_t materials() const { return materials_; }
  bool any_hertz() const {
    return std::any_of(laws_.begin(), laws_.end(),
                       [](const Law& law) { return law.kind == LawKind::hertz; });
  }

 private:
  std::size_t materials_;
  std::vector<Law> laws_;
  std::vector<double> friction_;  // mu of each law as declared
  std::vector<int> pair_;
};

// beta (share of critical damping in Tsuji's form) for which a collision without attraction has
// restitution e: bisection on the integrated collision.
double hertz_damping(double restitution, bool cut);

}  // namespace trackbed::dem
