// Forces of contacts. One kernel for all pairs of pieces, with the sphere's case (piece = particle)
// compiled apart, and the same law for pieces on surfaces.
#include <fmt/format.h>

#include <cmath>

#include "room.hpp"
#include "trackbed/core/exact_sum.hpp"

namespace trackbed::dem {

namespace {

struct Cross {
  double x, y, z;
};
inline Cross cross(double ax, double ay, double az, double bx, double by, double bz) {
  return {ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx};
}

// Arrays of the pair loop, so that the compiler sees plain pointers.
struct Arrays {
  const Vec4* __restrict piece_x;
  const std::int32_t* __restrict body;
  const Vec4* __restrict x;
  const Vec4* __restrict v;
  const Vec4* __restrict w;
  Vec4* __restrict f;
  Vec4* __restrict t;
};

// The touching part of the loop body; returns the force on i, with the torque arms applied.
template <bool spheres>
inline void touch_pair(const Arrays& a, const Law& law, double dt, std::size_t i, std::size_t j,
                       const Vec4& d, double squared, double reach, Vec4& xi, Vec4& sum_f,
                       Vec4& sum_t) {
  const Vec4 &pi = a.piece_x[i], &pj = a.piece_x[j];
  const auto bi = spheres ? i : static_cast<std::size_t>(a.body[i]);
  const auto bj = spheres ? j : static_cast<std::size_t>(a.body[j]);
  const double distance = std::sqrt(squared);
  const double over = 1.0 / std::max(distance, 1e-300);
  Touch touch;
  touch.nx = d.x * over, touch.ny = d.y * over, touch.nz = d.z * over;
  touch.delta = reach - distance;
  touch.root_mass = xi.w;
  touch.radius = law.kind == LawKind::linear ? 0 : pi.w * pj.w / reach;
  const double ci = pi.w - 0.5 * touch.delta, cj = pj.w - 0.5 * touch.delta;
  double rix = ci * touch.nx, riy = ci * touch.ny, riz = ci * touch.nz;
  double rjx = -cj * touch.nx, rjy = -cj * touch.ny, rjz = -cj * touch.nz;
  if constexpr (!spheres) {
    rix += pi.x - a.x[bi].x, riy += pi.y - a.x[bi].y, riz += pi.z - a.x[bi].z;
    rjx += pj.x - a.x[bj].x, rjy += pj.y - a.x[bj].y, rjz += pj.z - a.x[bj].z;
  }
  const Vec4 &vi = a.v[bi], &vj = a.v[bj], &wi = a.w[bi], &wj = a.w[bj];
  const Cross si = cross(wi.x, wi.y, wi.z, rix, riy, riz);
  const Cross sj = cross(wj.x, wj.y, wj.z, rjx, rjy, rjz);
  touch.vx = (vi.x + si.x) - (vj.x + sj.x);
  touch.vy = (vi.y + si.y) - (vj.y + sj.y);
  touch.vz = (vi.z + si.z) - (vj.z + sj.z);
  touch.twist =
      0.5 * ((wi.x + wj.x) * touch.nx + (wi.y + wj.y) * touch.ny + (wi.z + wj.z) * touch.nz);
  const Vec4 force = contact_force(law, touch, dt, xi);
  const Cross ti = cross(rix, riy, riz, force.x, force.y, force.z);
  const Cross tj = cross(rjx, rjy, rjz, force.x, force.y, force.z);
  sum_f.x += force.x, sum_f.y += force.y, sum_f.z += force.z;
  sum_t.x += ti.x, sum_t.y += ti.y, sum_t.z += ti.z;
  Vec4 &fj = a.f[bj], &tq = a.t[bj];
  fj.x -= force.x, fj.y -= force.y, fj.z -= force.z;
  tq.x -= tj.x, tq.y -= tj.y, tq.z -= tj.z;
}

// Returns the largest overlap over the smaller radius.
template <bool spheres>
double pair_loop(const Arrays& a, const LawTable& laws, PairList& list, double dt) {
  double worst = 0;
  for (const Row& row : list.rows) {
    const auto i = static_cast<std::size_t>(row.piece);
    const Vec4 pi = a.piece_x[i];
    Vec4 sum_f, sum_t;
    for (std::uint32_t e = row.begin; e < row.end; ++e) {
      Entry& entry = list.entries[e];
      const auto j = static_cast<std::size_t>(entry.piece);
      const Vec4& pj = a.piece_x[j];
      const Vec4& h = list.shifts[entry.shift];
      const Vec4 d{pj.x - pi.x + h.x, pj.y - pi.y + h.y, pj.z - pi.z + h.z, 0};
      const double squared = d.x * d.x + d.y * d.y + d.z * d.z;
      const double reach = pi.w + pj.w;
      Vec4& xi = list.xi[e];
      if (squared >= reach * reach) {
        if (entry.touching) {
          entry.touching = 0;
          xi.x = xi.y = xi.z = 0;
        }
        continue;
      }
      entry.touching = 1;
      touch_pair<spheres>(a, laws[entry.law], dt, i, j, d, squared, reach, xi, sum_f, sum_t);
      worst = std::max(worst, (reach - std::sqrt(squared)) / std::min(pi.w, pj.w));
    }
    const auto bi = spheres ? i : static_cast<std::size_t>(a.body[i]);
    Vec4 &f = a.f[bi], &t = a.t[bi];
    f.x += sum_f.x, f.y += sum_f.y, f.z += sum_f.z;
    t.x += sum_t.x, t.y += sum_t.y, t.z += sum_t.z;
  }
  return worst;
}

}  // namespace

void Particles::Room::feel_pairs(double dt) {
  std::fill(state.f.begin(), state.f.end(), Vec4{});
  std::fill(state.t.begin(), state.t.end(), Vec4{});
  const bool spheres = shapes.only_spheres();
  if (!spheres) place(state, shapes, pieces);
  const Arrays arrays{spheres ? state.x.data() : pieces.x.data(),
                      pieces.body.data(),
                      state.x.data(),
                      state.v.data(),
                      state.w.data(),
                      state.f.data(),
                      state.t.data()};
  const double worst = spheres ? pair_loop<true>(arrays, laws, pairs, dt)
                               : pair_loop<false>(arrays, laws, pairs, dt);
  if (worst > parameters.largest_overlap)
    report(
        fmt::format("two particles overlap by {:.3g} of the smaller radius (limit "
                    "dem.largest_overlap = {:.3g}); a smaller step, a stiffer contact or a "
                    "slower load may help",
                    worst, parameters.largest_overlap));
}

namespace {

// Adds the force to the nodes of the touched triangle by its shape functions (weights).
void load_nodes(Surface& surface, const MeshContact& c, const Vec3& force, double s) {
  const double over = 1.0 / surface.load_quantum;
  for (int k = 0; k < 3; ++k) {
    NodeLoad& load = surface.load[static_cast<std::size_t>(
        surface.triangles[static_cast<std::size_t>(c.triangle)][static_cast<std::size_t>(k)])];
    for (int a = 0; a < 3; ++a) {
      const double part = c.weight[k] * force[a] * over;
      load.force[static_cast<std::size_t>(a)] += std::llrint(part);
      load.first[static_cast<std::size_t>(a)] += std::llrint(s * part);
    }
  }
}

// The patch record of a contact, kept in the order of patches; new ones start without history.
Approach::Patch& patch_record(Approach& a, int patch) {
  auto at = std::find_if(a.patches.begin(), a.patches.end(),
                         [&](const Approach::Patch& p) { return p.patch >= patch; });
  if (at == a.patches.end() || at->patch != patch)
    at = a.patches.insert(at, Approach::Patch{patch, true, {}, {}});
  at->touching = true;
  return *at;
}

}  // namespace

void Particles::Room::feel_surfaces(double dt, double s, int steps_in_window) {
  const bool spheres = shapes.only_spheres();
  thread_local std::vector<MeshContact> found;
  double worst = 0;
  for (Approach& a : approaches) {
    const auto p = static_cast<std::size_t>(a.piece);
    const auto b = static_cast<std::size_t>(pieces.body[p]);
    const Vec4& piece = spheres ? state.x[b] : pieces.x[p];
    Surface& surface = *surfaces[static_cast<std::size_t>(a.surface)];
    const Vec3 centre = piece.vec3() + a.shift, body = state.x[b].vec3() + a.shift;
    for (Approach::Patch& patch : a.patches) patch.touching = false;
    found.clear();
    meshes[static_cast<std::size_t>(a.surface)].touch(centre, piece.w, a.triangles, surface, s,
                                                      found);
    for (const MeshContact& c : found) {
      Approach::Patch& patch = patch_record(a, c.patch);
      patch.contact = c;
      const auto& nodes = surface.triangles[static_cast<std::size_t>(c.triangle)];
      Vec3 motion = Vec3::Zero();  // of the surface at the contact, over the window
      for (int k = 0; k < 3; ++k)
        motion += c.weight[k] * surface.motion[static_cast<std::size_t>(nodes[k])];
      // From raw positions: which periodic image was taken must not change a bit.
      const Vec3 arm = (piece.vec3() - state.x[b].vec3()) + c.distance * c.normal;
      const Vec3 spin = state.w[b].vec3();
      const Vec3 v = state.v[b].vec3() + spin.cross(arm) - motion / (dt * steps_in_window);
      const Touch touch{c.normal.x(),
                        c.normal.y(),
                        c.normal.z(),
                        v.x(),
                        v.y(),
                        v.z(),
                        piece.w - c.distance,
                        std::sqrt(mass(b)),
                        piece.w,
                        0.5 * spin.dot(c.normal)};
      const Vec3 force = contact_force(law_of(a), touch, dt, patch.xi).vec3();
      const Vec3 torque = arm.cross(force);
      Vec4 &f = state.f[b], &t = state.t[b];
      f.set(f.vec3() + force);
      t.set(t.vec3() + torque);
      load_nodes(surface, c, -force, s);
      action.force -= force;
      action.moment -= body.cross(force) + torque;
      action.work -= force.dot(motion) / steps_in_window;
      worst = std::max(worst, touch.delta / piece.w);
    }
    std::erase_if(a.patches, [](const Approach::Patch& patch) { return !patch.touching; });
  }
  if (worst > parameters.largest_overlap)
    report(
        fmt::format("a particle overlaps a surface by {:.3g} of its radius (limit "
                    "dem.largest_overlap = {:.3g})",
                    worst, parameters.largest_overlap));
}

}  // namespace trackbed::dem
