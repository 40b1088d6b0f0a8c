// The law on contacts of pieces with corners, eight at a time. With the pair's generalised normal
// (N, T) the overlap grows at the rate M' = (v_i - v_j) . N + w_i . T - w_j . (T - D x N), D from
// the first centre to the second: spring and damper of the law act on M and M' and their force
// works on nothing else. Friction acts at the mean point of contact, in the plane across N;
// relative rotation about N is resisted like a ring of the contact's spread would do (zero for a
// corner). Resistance to rolling takes the balls around the two pieces for their radii.
#pragma once

#include <cmath>

#include "features.hpp"
#include "laws.hpp"
#include "pairs.hpp"
#include "stone_blocks.hpp"

namespace trackbed::dem {

// The overlap M (m) as the spring shall feel it in a sub-step in which the contact opens or closes.
//
// Velocity Verlet kicks with half a sub-step's force on either side of each pose, so where M begins
// (or ends) within the sub-step it gives the spring more time than it has: the energy of an elastic
// collision was wrong by up to (dt^2 k / m_c) / 4, m_c the effective mass at the contact (a corner:
// down to an eighth of a stone's), whatever the accuracy in between. With the rate M' the contact
// has acted for a = M / |M'| < dt on one side, and the exact impulse k |M'| a^2 / 2 there and k M
// dt / 2 on the other make the force k M (1 + a / dt) / 2. What is left is third order. A contact
// at rest, M > |M'| dt, is not changed. Hertz's force begins smoothly and needs none of this.
[[gnu::always_inline]] inline double felt_overlap(double M, double rate, double dt) {
  const double way = (rate < 0 ? -rate : rate) * dt;
  return M < way ? 0.5 * M * (1 + M / way) : M;
}

// One contact per lane. Places are relative to the centre of i. The surface's case
// (surface_contacts.cpp) uses lane 0 alone, with d and spin of j zero and `drift` for how its
// features move.
struct alignas(64) StoneGroup {
  Lane3 d, N, T, x, vi, vj, wi, wj, xi;  // in; d: centre of j from that of i
  double M[lanes], spread[lanes], turn[lanes], root_mass[lanes];
  double radius[lanes];  // m, of the two curvatures together
  LawLanes law;
  RollingLanes rolling;
  double drift[lanes];  // m/s, rate at which features of j move along N against its motion at x
  Lane3 force, turn_i, turn_j;       // out, on i; torque on j of the opposite force
  double f_n[lanes], moment[lanes];  // out: force along -N, moment of torsion
};

// Moment about the normal, on i, from a torsion spring of stiffness k_s spread, cut at the moment
// that friction can carry at this spread.
// As `slide` in one dimension, with lengths times sqrt(spread): a ring of that radius, twisted, has
// the stiffness k_s spread (Nm/rad) and slips at mu F_n sqrt(spread). Corners have no spread and no
// torsion.
[[gnu::always_inline]] inline double torsion(const Coefficients& c, double spread, double rate,
                                             double limit, double dt, double& turn) {
  const double stiffness = c.k_s * spread, damping = c.c_s * spread;
  const double grown = turn + rate * dt;
  const double moment = -stiffness * grown - damping * rate;
  const bool slips = moment > limit || moment < -limit;
  const double cut = moment > 0 ? limit : -limit;
  const double kept = stiffness > 0 ? -(cut + damping * rate) / stiffness : 0.0;
  turn = slips ? kept : (stiffness > 0 ? grown : 0.0);
  return slips ? cut : moment;
}

// Force on i: friction - f_n N, and torque x cross friction - f_n T + moment n; on j the opposite
// force, and the torque about its own centre. f_n is the spring's force on M, N; the normal force
// is f_n |N|, since |N| may exceed 1 (several features) or fall short of it (features that face
// each other); it limits friction and torsion.
template <bool rolls>
[[gnu::always_inline]] inline void respond(StoneGroup& g, std::size_t k, double dt) {
  const double Nx = g.N.x[k], Ny = g.N.y[k], Nz = g.N.z[k];
  const double Tx = g.T.x[k], Ty = g.T.y[k], Tz = g.T.z[k];
  const double dx = g.d.x[k], dy = g.d.y[k], dz = g.d.z[k];
  const double Sx = Tx - (dy * Nz - dz * Ny), Sy = Ty - (dz * Nx - dx * Nz),
               Sz = Tz - (dx * Ny - dy * Nx);  // T about the centre of j
  const double wix = g.wi.x[k], wiy = g.wi.y[k], wiz = g.wi.z[k];
  const double wjx = g.wj.x[k], wjy = g.wj.y[k], wjz = g.wj.z[k];
  const double length = std::sqrt(Nx * Nx + Ny * Ny + Nz * Nz);
  const double over = 1 / (length > 1e-300 ? length : 1e-300);
  const double nx = Nx * over, ny = Ny * over, nz = Nz * over;
  const double ax = g.x.x[k], ay = g.x.y[k], az = g.x.z[k];  // arms
  const double bx = ax - dx, by = ay - dy, bz = az - dz;
  const double ux = g.vi.x[k] - g.vj.x[k], uy = g.vi.y[k] - g.vj.y[k], uz = g.vi.z[k] - g.vj.z[k];
  const double rate = ux * Nx + uy * Ny + uz * Nz + (wix * Tx + wiy * Ty + wiz * Tz) -
                      (wjx * Sx + wjy * Sy + wjz * Sz) - g.drift[k];  // of M
  const double px = ux + (wiy * az - wiz * ay) - (wjy * bz - wjz * by);
  const double py = uy + (wiz * ax - wix * az) - (wjz * bx - wjx * bz);
  const double pz = uz + (wix * ay - wiy * ax) - (wjx * by - wjy * bx);
  // `contact_force` takes the rate of overlap from the velocity along n: here it is that of M.
  const double correct = rate - (px * nx + py * ny + pz * nz);
  const double vx = px + correct * nx, vy = py + correct * ny, vz = pz + correct * nz;
  Law law = g.law.at(k);
  law.mu *= length;
  const Coefficients c = coefficients<true>(law, g.M[k], g.root_mass[k], g.radius[k]);
  const double felt = g.law.rooted[k] > 0 ? g.M[k] : felt_overlap(g.M[k], rate, dt);
  const double twist = 0.5 * ((wix + wjx) * nx + (wiy + wjy) * ny + (wiz + wjz) * nz);
  Vec4 xi{g.xi.x[k], g.xi.y[k], g.xi.z[k], 0};
  const Vec4 f = contact_force(c, {nx, ny, nz, vx, vy, vz, felt, twist}, dt, xi);
  g.xi.x[k] = xi.x, g.xi.y[k] = xi.y, g.xi.z[k] = xi.z;
  const double f_n = f.w;
  const double sx = f.x + f_n * nx, sy = f.y + f_n * ny, sz = f.z + f_n * nz;  // friction
  double turn = g.turn[k];
  const double limit = c.mu * (f_n > 0 ? f_n : 0.0) * std::sqrt(g.spread[k]);
  const double spin = (wix - wjx) * nx + (wiy - wjy) * ny + (wiz - wjz) * nz;
  const double moment = torsion(c, g.spread[k], spin, limit, dt, turn);
  g.turn[k] = turn, g.f_n[k] = f_n, g.moment[k] = moment;
  g.force.x[k] = sx - f_n * Nx, g.force.y[k] = sy - f_n * Ny, g.force.z[k] = sz - f_n * Nz;
  g.turn_i.x[k] = (ay * sz - az * sy) - f_n * Tx + moment * nx;
  g.turn_i.y[k] = (az * sx - ax * sz) - f_n * Ty + moment * ny;
  g.turn_i.z[k] = (ax * sy - ay * sx) - f_n * Tz + moment * nz;
  g.turn_j.x[k] = (by * sz - bz * sy) - f_n * Sx + moment * nx;
  g.turn_j.y[k] = (bz * sx - bx * sz) - f_n * Sy + moment * ny;
  g.turn_j.z[k] = (bx * sy - by * sx) - f_n * Sz + moment * nz;
  if constexpr (rolls) {
    const Rolls t{nx,        ny,        nz,           twist, wix - wjx,
                  wiy - wjy, wiz - wjz, f_n * length, 0,     g.root_mass[k]};
    const Vec4 m = g.rolling.moment(k, c.k_n, t, dt);
    g.turn_i.x[k] += m.x, g.turn_i.y[k] += m.y, g.turn_i.z[k] += m.z;
    g.turn_j.x[k] += m.x, g.turn_j.y[k] += m.y, g.turn_j.z[k] += m.z;
  }
}

// What pairs do to their particles, by slot (block and lane).
struct PairForces {
  std::vector<Vec4> force, turn_i, turn_j;  // N on i, the opposite on j; Nm, turn_j less on j
  void resize(std::size_t slots) {
    for (auto* rows : {&force, &turn_i, &turn_j})
      if (rows->size() < slots) rows->resize(slots);
  }
  std::size_t memory() const { return 3 * force.capacity() * sizeof(Vec4); }
};

struct PlaceOfPair {
  std::uint32_t slot, i, j;  // particles
};

// Adds them in the order given.
void add(const std::vector<PlaceOfPair>& order, const PairForces& forces, State& state);

// The law on blocks of pairs, one after the other.
class StoneLaw {
 public:
  StoneLaw(const Scene& scene, double dt, StoneList& list, PairForces& forces);
  // Moves the histories of block `number` by dt and leaves its forces. A pair that does not overlap
  // has neither.
  void respond(std::size_t number, const Block& block, const WrenchLanes& w);
  // Begins to load what the law will read of a block: rows that are in no order of addresses.
  void prefetch(const Block& block) const;
  double largest_overlap() const;  // over the smaller radius

 private:
  template <bool rolls>
  void respond_to(const Block& block, const WrenchLanes& w, Mask touching);
  void store_history(const Block& block, Mask touching);

  const Scene& scene_;
  double dt_;
  StoneList& list_;
  PairForces& forces_;
  int law_ = -1;  // that the lanes of `group_` hold
  Lanes worst_ = all(0);
  StoneGroup group_{};
};

}  // namespace trackbed::dem
