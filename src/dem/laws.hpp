// What a contact does, as pure functions of overlap, velocities, history and parameters.
//
// linear: F_n = k_n delta + c_n v_n, F_s = -k_s xi - c_s v_t, |F_s| <= mu F_n
//   (Cundall, Strack 1979, doi:10.1680/geot.1979.29.1.47), c = 2 zeta sqrt(m_eff k).
// hertz: k_n = 4/3 E* sqrt(R delta), k_s = 8 G* sqrt(R delta) (Mindlin 1949), damping
//   2 sqrt(5/6) beta sqrt(S m_eff), S = 2 E* sqrt(R delta) (Tsuji et al. 1992,
//   doi:10.1016/0032-5910(92)88030-L), beta found such that the collision, with no attraction,
//   has the wanted restitution.
// The tangential history xi stays in the tangent plane: projected on it, turned with the spin about
// the normal, and shortened when the force slips (the limit is applied in `slide`).
// Rolling is resisted by a spring with dashpot and slider of the same kind (`rolling_force`).
#pragma once

#include <algorithm>
#include <cmath>

#include "lanes.hpp"
#include "trackbed/dem/law.hpp"
#include "vec4.hpp"

namespace trackbed::dem {

// Resistance to rolling; with mu = 0 the slider carries nothing and its history stays zero.
struct Rolling {
  double mu = 0, stiffness = 1, zeta = 0;
};

// One pair of materials, ready for the kernels. They know no kinds of laws, only this: which kind
// becomes what is chosen in laws.cpp (`law_of`), for each kind there is.
struct Law {
  bool rooted = false;      // stiffnesses grow with sqrt(R delta)
  double least = 0;         // N, F_n >= least: 0 without attraction, else -infinity
  double k_n = 0, k_s = 0;  // N/m; rooted: over sqrt(R delta), Pa
  double c_n = 0, c_s = 0;  // over sqrt(m_eff): 2 zeta sqrt(k)
  double mu = 0;
  Rolling rolling = {};
};

// Stiffnesses and damping at one overlap.
// m_eff = m_i m_j / (m_i + m_j), kg; against a surface m_i, since what is behind it is heavy.
struct Coefficients {
  double k_n, k_s, c_n, c_s, mu, least;
};

// R: 1/R = 1/R_i + 1/R_j (m); root_mass: sqrt of the effective mass. `any_rooted` false: no law
// is, and the roots are left out.
template <bool any_rooted>
[[gnu::always_inline]] inline Coefficients coefficients(const Law& law, double delta,
                                                        double root_mass, double radius) {
  if constexpr (any_rooted) {
    const double a = law.rooted ? std::sqrt(radius * delta) : 1.0;
    const double damping = std::sqrt(a) * root_mass;
    return {law.k_n * a, law.k_s * a, law.c_n * damping, law.c_s * damping, law.mu, law.least};
  }
  return {law.k_n, law.k_s, law.c_n * root_mass, law.c_s * root_mass, law.mu, law.least};
}

// Elastic energy stored in a contact, J.
// The integral of F over delta, plus the tangential spring. With hertz k_s depends on delta while
// xi is kept: the tangential part is then what the spring would give back at this overlap, not what
// was put in.
inline double stored_energy(const Law& law, double delta, double radius, const Vec4& xi) {
  const Coefficients c = coefficients<true>(law, delta, 0, radius);
  const double share = law.rooted ? 0.4 : 0.5;  // of F delta: F grows with delta^1.5 or delta
  return share * c.k_n * delta * delta + 0.5 * c.k_s * (xi.x * xi.x + xi.y * xi.y + xi.z * xi.z);
}

// And in its resistance to rolling, J.
inline double rolling_energy(const Law& law, double delta, double radius, const Vec4& roll) {
  const double k = law.rolling.stiffness * coefficients<true>(law, delta, 0, radius).k_n;
  return 0.5 * k * (roll.x * roll.x + roll.y * roll.y + roll.z * roll.z);
}

// What one contact is computed from: normal n from i to j (surface: into it), relative velocity v
// of i against j at the contact, twist = mean spin of the two about n.
struct Touch {
  double nx, ny, nz, vx, vy, vz, delta, twist;
};

// A spring with dashpot in the tangent plane and a slider that gives way at `limit`.
struct Slider {
  double k, c;   // N/m, Ns/m
  double limit;  // N
};

// What drives it: the normal, the velocity in the plane across it, the spin of the contact about
// it.
struct Sliding {
  double nx, ny, nz, vx, vy, vz, twist;
};

// Its force against v; moves the displacement xi (m) by dt. Selects instead of branches, so that
// the pair loop runs it on eight contacts at a time.
[[gnu::always_inline]] inline Vec4 slide(const Slider& s, const Sliding& t, double dt, Vec4& xi) {
  // First the part along the new normal is taken off (the tangent plane has turned), then the rest
  // is turned with the contact, then moved with the surfaces.
  const double along = xi.x * t.nx + xi.y * t.ny + xi.z * t.nz;
  const double px = xi.x - along * t.nx, py = xi.y - along * t.ny, pz = xi.z - along * t.nz;
  const double turn = t.twist * dt;
  const double x = px + turn * (t.ny * pz - t.nz * py) + t.vx * dt;
  const double y = py + turn * (t.nz * px - t.nx * pz) + t.vy * dt;
  const double z = pz + turn * (t.nx * py - t.ny * px) + t.vz * dt;
  const double fx = -s.k * x - s.c * t.vx, fy = -s.k * y - s.c * t.vy, fz = -s.k * z - s.c * t.vz;
  // When the limit acts, the history becomes the spring that carries exactly this force (without a
  // spring it has no use and is zero).
  const double f2 = fx * fx + fy * fy + fz * fz;
  const bool slips = f2 > s.limit * s.limit;
  const double scale = slips ? s.limit / std::sqrt(f2) : 1.0;
  const double soft = s.k > 0 ? -1.0 / s.k : 0.0;
  const double sx = scale * fx, sy = scale * fy, sz = scale * fz;
  xi.x = slips ? soft * (sx + s.c * t.vx) : x;
  xi.y = slips ? soft * (sy + s.c * t.vy) : y;
  xi.z = slips ? soft * (sz + s.c * t.vz) : z;
  return {sx, sy, sz, 0};
}

// Force on i; moves the history xi by dt. The partner gets the opposite force. The friction is
// cut at Coulomb's limit.
[[gnu::always_inline]] inline Vec4 contact_force(const Coefficients& c, const Touch& t, double dt,
                                                 Vec4& xi) {
  // Spring and dashpot in parallel. Their sum is cut, not the dashpot alone: damping may take away
  // all of the spring's force but, without attraction, no more.
  const double v_n = t.vx * t.nx + t.vy * t.ny + t.vz * t.nz;  // > 0: approaching
  const double free_n = c.k_n * t.delta + c.c_n * v_n;
  const double f_n = free_n > c.least ? free_n : c.least;
  const double vtx = t.vx - v_n * t.nx, vty = t.vy - v_n * t.ny, vtz = t.vz - v_n * t.nz;
  // No friction from a contact that pulls.
  const double limit = c.mu * (f_n > 0 ? f_n : 0.0);
  const Vec4 s = slide({c.k_s, c.c_s, limit}, {t.nx, t.ny, t.nz, vtx, vty, vtz, t.twist}, dt, xi);
  return {s.x - f_n * t.nx, s.y - f_n * t.ny, s.z - f_n * t.nz, f_n};
}

// What resistance to rolling reads: normal n and twist as in Touch, spin of i less that of j, force
// along the normal, and R: 1/R = 1/R_i + 1/R_j (m), R_i the radius of the ball around the piece (a
// surface is flat: R = R_i).
struct Rolls {
  double nx, ny, nz, twist, wx, wy, wz, f_n, radius, root_mass;
};

// Resistance to rolling by an elastic spring, a dashpot and a slider (Ai, Chen, Rotter, Ooi 2011,
// doi:10.1016/j.powtec.2010.09.030, model C; Iwashita, Oda 1998), in lengths instead of angles:
//   d roll/dt = R (w_i - w_j)_t,  f = -k roll - c d roll/dt,  |f| <= mu_r F_n,  moment on i = R f,
// j gets the opposite moment; k = rolling_stiffness k_n, so k_r = k R^2 per angle, and
// c = 2 zeta_r sqrt(k m_eff). The rate of rolling is the tangential part of the relative spin times
// the reduced radius (Luding 2008, doi:10.1007/s10035-008-0099-x): an observer that turns with the
// pair sees the same, whatever the two radii, it is zero when the pair turns as one body, and the
// moment works on nothing else, so that no energy is gained. Here the limit cuts the sum of spring
// and dashpot, not the spring alone; critical damping is that of the inertia m_eff R^2 (a sphere on
// a plane has 7/5 of it).
[[gnu::always_inline]] inline Vec4 rolling_force(const Rolling& law, double k_n, const Rolls& t,
                                                 double dt, Vec4& roll) {
  const double k = law.stiffness * k_n;
  const double c = 2 * law.zeta * std::sqrt(k) * t.root_mass;
  const double limit = law.mu * (t.f_n > 0 ? t.f_n : 0.0);
  const double spin = t.wx * t.nx + t.wy * t.ny + t.wz * t.nz;
  const double vx = t.radius * (t.wx - spin * t.nx), vy = t.radius * (t.wy - spin * t.ny),
               vz = t.radius * (t.wz - spin * t.nz);
  return slide({k, c, limit}, {t.nx, t.ny, t.nz, vx, vy, vz, t.twist}, dt, roll);
}

// The laws of eight contacts, for loops over lanes.
struct alignas(64) LawLanes {
  double k_n[lanes], k_s[lanes], c_n[lanes], c_s[lanes], mu[lanes], least[lanes], rooted[lanes];
  void set(std::size_t k, const Law& law) {
    k_n[k] = law.k_n, k_s[k] = law.k_s, c_n[k] = law.c_n, c_s[k] = law.c_s;
    mu[k] = law.mu, least[k] = law.least;
    rooted[k] = law.rooted;
  }
  // Without rolling, which has lanes of its own.
  [[gnu::always_inline]] Law at(std::size_t k) const {
    return {rooted[k] > 0, least[k], k_n[k], k_s[k], c_n[k], c_s[k], mu[k], {}};
  }
};

// Their resistance to rolling and its history; filled only if any law has one.
struct alignas(64) RollingLanes {
  double mu[lanes], stiffness[lanes], zeta[lanes];
  double radius[lanes];  // m, reduced
  Lane3 roll;
  void set(std::size_t k, const Rolling& law, double r, const Vec4& history) {
    mu[k] = law.mu, stiffness[k] = law.stiffness, zeta[k] = law.zeta;
    radius[k] = r, roll.put(k, history);
  }
  // Moment on i; moves the history.
  [[gnu::always_inline]] Vec4 moment(std::size_t k, double k_n, Rolls t, double dt) {
    t.radius = radius[k];
    Vec4 history{roll.x[k], roll.y[k], roll.z[k], 0};
    const Vec4 f = rolling_force({mu[k], stiffness[k], zeta[k]}, k_n, t, dt, history);
    roll.x[k] = history.x, roll.y[k] = history.y, roll.z[k] = history.z;
    return {t.radius * f.x, t.radius * f.y, t.radius * f.z, 0};
  }
};

// An entry of the neighbour list has a byte for its law (pairs.hpp).
inline constexpr std::size_t most_laws = 256;

// Laws of all pairs of materials, from the deck's declarations. Throws InputError for a pair given
// twice or an unknown material; `index` is -1 for a pair that is not given.
class LawTable {
 public:
  explicit LawTable(const Physics& physics);
  // Symmetric: a law holds between two materials, whichever is named first.
  int index(int material_i, int material_j) const {
    return pair_[static_cast<std::size_t>(material_i) * materials_ +
                 static_cast<std::size_t>(material_j)];  // -1: not declared
  }
  const Law& operator[](std::size_t index) const { return laws_[index]; }
  // `mu` is the friction of every law from now on; below 0: each has its own again.
  void override_friction(double mu);
  const std::vector<Law>& all() const { return laws_; }
  std::size_t materials() const { return materials_; }
  bool any_rooted() const {
    return std::any_of(laws_.begin(), laws_.end(), [](const Law& law) { return law.rooted; });
  }
  bool any_rolls() const { return rolls_; }

 private:
  std::size_t materials_;
  bool rolls_ = false;
  std::vector<Law> laws_;
  std::vector<double> friction_;  // mu of each law as declared
  std::vector<int> pair_;
};

// beta (share of critical damping in Tsuji's form) for which a collision without attraction has
// restitution e: bisection on the integrated collision.
double hertz_damping(double restitution, bool cut);

}  // namespace trackbed::dem
