// Forces of pieces on surfaces, and their distribution to the nodes of the triangles. Pieces with
// one corner are balls: contacts found by mesh.hpp, the law of contact.hpp. The others: contacts
// found by stone_surface.hpp, the law of stone_law.hpp on their smooth maximum.
#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "dem/contact/stone_law.hpp"
#include "dem/particles/impl.hpp"
#include "dem/state/rotation.hpp"
#include "trackbed/core/exact_sum.hpp"

namespace trackbed::dem {

namespace {

// Modulo 2^64, which is defined and associative: the quantum keeps the sums of a window below that
// limit (Particles::expect_load), but those of a surface whose load is never read may overflow. The
// coupler's balance detects sums that did.
void add_to(std::int64_t& sum, double quanta) {
  sum = static_cast<std::int64_t>(static_cast<std::uint64_t>(sum) +
                                  static_cast<std::uint64_t>(std::llrint(quanta)));
}

// Rounded once for each force and added as an integer (core/exact_sum.hpp): stones of several ranks
// load one node, in any order. `first` is weighted with the fraction s of the window; with both
// sums the moment about any point is known although the node moves. `over`: 1 / quantum.
void load_node(Surface& surface, std::int32_t node, const Vec3& force, double s, double over) {
  NodeLoad& load = surface.load[static_cast<std::size_t>(node)];
  for (int a = 0; a < 3; ++a) {
    const double part = force[a] * over;
    add_to(load.force[static_cast<std::size_t>(a)], part);
    add_to(load.first[static_cast<std::size_t>(a)], s * part);
  }
}

// Adds the force to the nodes of the triangle by its shape functions (weights). F_k = phi_k F, sum
// phi_k = 1: force and moment about any point are preserved.
void load_nodes(Surface& surface, const MeshContact& c, const Vec3& force, double s) {
  const auto& nodes = surface.triangles[static_cast<std::size_t>(c.triangle)];
  const double over = 1.0 / surface.load_quantum;
  for (int k = 0; k < 3; ++k)
    load_node(surface, nodes[static_cast<std::size_t>(k)], c.weight[k] * force, s, over);
}

// Displacement of the surface at the contact in one sub-step, m. It is interpolated by the shape
// functions that distribute the force, so that force times displacement is the work on both sides.
Vec3 motion_at(const Surface& surface, const MeshContact& c, const SubStep& step) {
  const auto& nodes = surface.triangles[static_cast<std::size_t>(c.triangle)];
  Vec3 motion = Vec3::Zero();
  for (int k = 0; k < 3; ++k)
    motion += c.weight[k] * surface.motion[static_cast<std::size_t>(nodes[k])];
  return motion / step.count;
}

// The patch record of a contact, stored in the order of patches; new ones start without history.
Approach::Patch& patch_record(Approach& a, int patch) {
  auto at = std::find_if(a.patches.begin(), a.patches.end(),
                         [&](const Approach::Patch& p) { return p.patch >= patch; });
  if (at == a.patches.end() || at->patch != patch)
    at = a.patches.insert(at, Approach::Patch{.patch = patch, .touching = true});
  at->touching = true;
  return *at;
}

}  // namespace

// What a contact with a surface dissipates is the particle's alone; of the sums of a sub-step it
// gets half in `update_accounts`, as in a contact with another particle.
void Particles::Impl::account(std::size_t b, const Dissipation<double>& spent) {
  state.t[b].w += spent.friction;
  state.f[b].w += spent.damping;
  if (!parameters.energy_balance) return;
  state.account[b].x += 0.5 * spent.friction, state.account[b].y += 0.5 * spent.damping;
}

// `force` acts on the particle; the opposite is added to the nodes, which move by `motion` (m) at
// the contact, and to the window's action. The moment is summed by the caller, which has the arm.
void Particles::Impl::add_to_surface(const Approach& a, const MeshContact& c, const Vec3& force,
                                     const Vec3& motion, const SubStep& step) {
  load_nodes(*surfaces[static_cast<std::size_t>(a.surface)], c, -force, step.fraction);
  action.work -= force.dot(motion);
}

// A force on node k of a triangle, and its work.
void Particles::Impl::add_to_node(Surface& surface, int triangle, std::size_t k, const Vec3& force,
                                  const SubStep& step) {
  const std::int32_t node = surface.triangles[static_cast<std::size_t>(triangle)][k];
  load_node(surface, node, force, step.fraction, 1.0 / surface.load_quantum);
  action.work += force.dot(surface.motion[static_cast<std::size_t>(node)]) / step.count;
}

// Force and torque of one contact of a ball on its particle, the opposite on the surface.
void Particles::Impl::apply_ball_contact(Approach& a, const MeshContact& c, const SubStep& step) {
  const auto p = static_cast<std::size_t>(a.piece);
  const auto b = static_cast<std::size_t>(pieces.body[p]);
  const Vec4& piece = shapes.only_spheres() ? state.x[b] : pieces.x[p];
  const Surface& surface = *surfaces[static_cast<std::size_t>(a.surface)];
  // Overlap, normal and point are stored for output (`measure.cpp`); the history is advanced by the
  // law.
  Approach::Patch& patch = patch_record(a, c.patch);
  patch.overlap = piece.w - c.distance, patch.radius = piece.w;
  patch.N = c.normal, patch.point = c.point - a.shift;
  // The arm ends on the surface, at R - delta: there the force is applied to the nodes, so that
  // both sides use one point (docs/decisions/stones_on_surfaces.md describes the effect). From raw
  // positions: the result must not depend on the periodic image.
  const Vec3 arm = (piece.vec3() - state.x[b].vec3()) + c.distance * c.normal;
  const Vec3 spin = state.w[b].vec3();
  const Vec3 motion = motion_at(surface, c, step);
  Vec3 v = state.v[b].vec3() + spin.cross(arm) - motion / step.dt;
  // The arm of half a step before, as between spheres (pair_contacts.cpp).
  const double rate = v.dot(c.normal);
  v += 0.5 * step.dt * rate * spin.cross(c.normal);
  // A surface has no spin: the contact rotates with half the particle's spin about the normal.
  const Touch<double> touch{triple(c.normal), triple(v), patch.overlap, 0.5 * spin.dot(c.normal)};
  const Springs<double>& law = laws[static_cast<std::size_t>(a.law)].springs;
  const double root_mass = std::sqrt(mass(b));
  const auto k = coefficients<true>(law, touch.delta, root_mass, piece.w);
  // The corrections at the ends of a contact need the speed that a force changes in a step; the
  // damper's mass is part of the law.
  const double mass_at_end =
      shapes.only_spheres()
          ? root_mass * root_mass
          : 1 / (1 / mass(b) + inverse_mass_of_turning(state, b, triple(arm.cross(c.normal))));
  const NormalSpring<double> spring = spring_force<true>(
      law, k, OverlapMotion<double>{touch.delta, rate}, end_mass(mass_at_end), piece.w, step.dt);
  const double softer = softening(patch.size, k.size);
  Triple<double> xi = triple(patch.xi.vec3());
  const auto contact = contact_force(k, touch, spring, softer, step.dt, xi);
  patch.xi.set(vec3(xi)), patch.size = k.size;
  if (!breaking.strength.empty())
    watch(p, laws[static_cast<std::size_t>(a.law)], piece.w, touch.delta);
  const Vec3 force = vec3(contact.friction) - contact.normal * c.normal, torque = arm.cross(force);
  state.f[b].set(state.f[b].vec3() + force);
  state.t[b].set(state.t[b].vec3() + torque);
  account(b, contact.spent);
  add_to_surface(a, c, force, motion, step);
  action.force -= force;
  action.moment -= (state.x[b].vec3() + a.shift).cross(force) + torque;
  constexpr double whole = 1;
  if (laws.any_rolls())
    add_rolling_resistance(
        a, patch,
        {std::span(&c, 1), std::span(&whole, 1), k.k_n, contact.normal, contact.next, softer},
        step);
}

double Particles::Impl::touch_with_ball(Approach& a, const SubStep& step) {
  thread_local std::vector<MeshContact> found;  // keeps its capacity: no allocation per step
  const auto p = static_cast<std::size_t>(a.piece), k = static_cast<std::size_t>(a.surface);
  const Vec4& piece =
      shapes.only_spheres() ? state.x[static_cast<std::size_t>(pieces.body[p])] : pieces.x[p];
  const double path = surface_path[k] + step.fraction * surface_travel[k];
  if (a.clear.holds(piece, path)) return 0;
  const Ball ball{piece.vec3() + a.shift, piece.w};
  found.clear();
  meshes[k].touch(ball, a.triangles, *surfaces[k], step.fraction, found);
  if (found.empty())
    a.clear = {piece, path + meshes[k].distance(ball, a.triangles, *surfaces[k], step.fraction)};
  double worst = 0;
  for (const MeshContact& c : found) {
    apply_ball_contact(a, c, step);
    worst = std::max(worst, (piece.w - c.distance) / piece.w);
  }
  return worst;
}

// Relative to the particle's centre, which is in `origin` with the shift: corners keep their
// digits, and the surface is shifted to the stone. The corners are valid until the next call.
StoneView Particles::Impl::stone_view(const Approach& a, double fraction) const {
  const auto p = static_cast<std::size_t>(a.piece), k = static_cast<std::size_t>(a.surface);
  const auto b = static_cast<std::size_t>(pieces.body[p]);
  const Vec3 centre = state.x[b].vec3();
  thread_local std::vector<Vec4> corners;
  corners.clear();
  append_corners(shapes, pieces, p, corners);
  return {{&shapes.core(pieces.core[p]), corners, Vec3::Zero(), pieces.rounding[p]},
          {pieces.x[p].vec3() - centre, pieces.x[p].w},
          meshes[k],
          *surfaces[k],
          fraction,
          centre + a.shift};
}

double Particles::Impl::touch_with_corners(Approach& a, const SubStep& step) {
  thread_local std::vector<MeshContact> found;
  const auto k = static_cast<std::size_t>(a.surface);
  const auto b = static_cast<std::size_t>(pieces.body[static_cast<std::size_t>(a.piece)]);
  const double path = pieces.path[b] + surface_path[k] + step.fraction * surface_travel[k];
  // Both paths together bound the closure of a gap.
  const bool old = !(path < a.near.until);
  if (!old && a.near.features.empty()) return 0;
  const StoneView s = stone_view(a, step.fraction);
  if (old)
    find_features(s, a.triangles, path, pieces.pace[b] + surface_travel[k] / step.count, a.near);
  found.clear();
  const int lost = touch_surface(s, a.near.features, found);
  // Points that were never in contact with the patch may be behind it.
  if (std::any_of(a.patches.begin(), a.patches.end(),
                  [&](const Approach::Patch& p) { return p.patch == lost; }))
    report(
        fmt::format("a piece of particle {} at ({:.3g}, {:.3g}, {:.3g}) m has penetrated the "
                    "surface \"{}\" by more than {} times its own bounding radius: deeper contacts "
                    "are not detected; reduce time.step or dem.safety, or use stiffer contacts",
                    state.id[b], state.x[b].vec3().x(), state.x[b].vec3().y(),
                    state.x[b].vec3().z(), s.surface.name, largest_corner_depth));
  double worst = 0;
  for (std::size_t begin = 0, end = 0; begin < found.size(); begin = end) {
    while (end < found.size() && found[end].patch == found[begin].patch) ++end;
    worst = std::max(worst, apply_patch_contact(a, std::span(found).subspan(begin, end - begin),
                                                s.stone.radius, step));
  }
  return worst;
}

// Weights of the contacts of a piece with one patch and the motion of the surface there. Its arrays
// keep their capacity: no allocation per step.
struct Particles::Impl::PatchMotion {
  std::vector<double> slope;  // s_k = dM/d delta_k, of each contact
  double total = 0;           // of the slopes
  std::vector<Vec3> motions;  // m, of the surface at each contact
  Vec3 motion;                // m, at the mean point of contact
  double closing = 0;         // m, of the features on the surface, along N

  void set(std::span<const MeshContact> contacts, double rounding, double M, const Surface& surface,
           const SubStep& step) {
    slope.clear(), motions.clear();
    total = closing = 0, motion = Vec3::Zero();
    for (const MeshContact& c : contacts) {
      const double ratio = (rounding - c.distance) / M, square = ratio * ratio;
      slope.push_back(square * square * ratio);
      total += slope.back();
    }
    for (std::size_t k = 0; k < contacts.size(); ++k) {
      const Vec3& u = motions.emplace_back(motion_at(surface, contacts[k], step));
      motion += slope[k] / total * u;
      closing += slope[k] * contacts[k].normal.dot(u);
    }
  }
};

// All contacts of a piece with one patch act as one. The same law as between stones
// (stone_law.hpp), i the stone and j the surface, which has no rotation of its own: its motion at
// the mean point is that of its nodes, and `drift` is the additional motion of its features along
// N.
double Particles::Impl::apply_patch_contact(Approach& a, std::span<const MeshContact> contacts,
                                            double rounding, const SubStep& step) {
  Overlaps overlaps;
  for (const MeshContact& c : contacts) overlaps.add(rounding - c.distance, c.normal, c.point);
  const Wrench w = overlaps.result();
  if (!(w.M > 0)) return 0;
  thread_local PatchMotion on_patch;
  const Surface& surface = *surfaces[static_cast<std::size_t>(a.surface)];
  on_patch.set(contacts, rounding, w.M, surface, step);
  const auto b = static_cast<std::size_t>(pieces.body[static_cast<std::size_t>(a.piece)]);
  Approach::Patch& patch = patch_record(a, contacts[0].patch);
  patch.overlap = w.M, patch.radius = rounding, patch.spread = w.spread, patch.N = w.N;
  patch.point = w.x + state.x[b].vec3();
  StoneTouch<double> g{};
  g.N = triple(w.N), g.T = triple(w.T), g.x = triple(w.x), g.M = w.M, g.spread = w.spread;
  g.vi = triple(state.v[b].vec3()), g.wi = triple(state.w[b].vec3());
  g.vj = triple(on_patch.motion / step.dt);
  g.drift = (on_patch.closing - on_patch.motion.dot(w.N)) / step.dt;
  g.root_mass = std::sqrt(mass(b)), g.radius = rounding;
  g.inverse_moment_i = largest_inverse_moment(state, b), g.inverse_moment_j = 0;
  g.law = laws[static_cast<std::size_t>(a.law)].springs;
  StoneStretch<double> h{triple(patch.xi.vec3()), {}, patch.turn, patch.size, patch.ring};
  const auto yielding = [&](const Triple<double>&, bool) {
    return inverse_mass_of_turning(state, b, triple(w.T));
  };
  const StoneForce<double> f = respond<false>(g, yielding, step.dt, h);
  const double softer = softening(patch.size, h.size);
  patch.xi.set(vec3(h.xi)), patch.turn = h.turn, patch.size = h.size, patch.ring = h.ring;
  load_patch(a, contacts, on_patch, w, f, step);
  account(b, f.spent);
  if (laws.any_rolls())
    add_rolling_resistance(
        a, patch,
        {contacts, on_patch.slope, f.k_n, f.f_n * w.N.norm(), f.next * w.N.norm(), softer}, step);
  return w.M / rounding;
}

// Each contact applies its part of the force to its own triangle, so that the surface gets the
// opposite of the stone's force and moment to rounding. Force on feature k, with the slopes
// s_k = (delta_k / M)^5 as in features.hpp and S = sum s_k:
//   s_k/S (friction + ring x (x_k - x)) - f_n s_k n_k,  ring = moment/spread along N.
// The normal part is not averaged but applied to each feature along its own normal. The ring forces
// have no resultant; about N they give the required moment if the points are in a plane across N,
// because spread is the mean square of the arms.
void Particles::Impl::load_patch(const Approach& a, std::span<const MeshContact> contacts,
                                 const PatchMotion& patch, const Wrench& w,
                                 const StoneForce<double>& f, const SubStep& step) {
  const auto b = static_cast<std::size_t>(pieces.body[static_cast<std::size_t>(a.piece)]);
  // Plain numbers, as in mesh.cpp.
  const Triple<double> ring =
      triple(w.spread > 0 ? Vec3(f.moment / w.spread * w.N.normalized()) : Vec3(Vec3::Zero()));
  const Triple<double> middle = triple(w.x);
  Triple<double> forces{}, torques{};
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const MeshContact& c = contacts[k];
    const Triple<double> at = triple(c.point);
    const Triple<double> part =
        (patch.slope[k] / patch.total) * (f.friction + cross(ring, at - middle)) -
        (f.f_n * patch.slope[k]) * triple(c.normal);
    add_to_surface(a, c, vec3(part), patch.motions[k], step);
    forces = forces + part, torques = torques + cross(at, part);
  }
  const Vec3 force = vec3(forces), torque = vec3(torques);
  state.f[b].set(state.f[b].vec3() + force);
  state.t[b].set(state.t[b].vec3() + torque);
  action.force -= force;
  action.moment -= (state.x[b].vec3() + a.shift).cross(force) + torque;
}

// Paths of surfaces by their fastest node, m: an upper bound for any point of them. Called once in
// each window; within it the travel grows with the fraction. Motion of a surface between windows
// counts too.
void Particles::Impl::update_surface_paths() {
  const auto farthest = [](const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
    double most = 0;  // nodes far from all stones may be unknown (not a number)
    for (std::size_t n = 0; n < from.size(); ++n) {
      const double travel = (to[n] - from[n]).norm();
      if (travel > most) most = travel;
    }
    return most;
  };
  for (std::size_t k = 0; k < surfaces.size(); ++k) {
    const Surface& surface = *surfaces[k];
    surface_path[k] += surface_travel[k] + farthest(surface_last[k], surface.position);
    surface_last[k].resize(surface.nodes());
    for (std::size_t n = 0; n < surface.nodes(); ++n)
      surface_last[k][n] = surface.position[n] + surface.motion[n];
    surface_travel[k] = farthest(surface.position, surface_last[k]);
  }
}

void Particles::Impl::compute_surface_forces(const SubStep& step) {
  double worst = 0;
  const Approach* deepest = nullptr;
  constexpr std::size_t ahead = 3;  // the kept features may be anywhere in memory
  for (std::size_t n = 0; n < approaches.size(); ++n) {
    if (n + ahead < approaches.size()) {
      __builtin_prefetch(approaches[n + ahead].near.features.data());
      __builtin_prefetch(approaches[n + ahead].patches.data());
    }
    Approach& a = approaches[n];
    for (Approach::Patch& patch : a.patches) patch.touching = false;
    // Of this contact alone: the sum over a rank's contacts would be rounded otherwise on others.
    const double work = std::exchange(action.work, 0);
    const double overlap =
        has_corners(a.piece) ? touch_with_corners(a, step) : touch_with_ball(a, step);
    const auto b = static_cast<std::size_t>(pieces.body[static_cast<std::size_t>(a.piece)]);
    if (parameters.energy_balance) state.account[b].w -= action.work;
    action.work += work;
    if (overlap > worst) worst = overlap, deepest = &a;
    // A patch that is not in contact any more loses its history. As between particles, the springs
    // vanish at once.
    std::erase_if(a.patches, [](const Approach::Patch& patch) { return !patch.touching; });
  }
  if (worst <= parameters.largest_overlap) return;
  const auto b = static_cast<std::size_t>(pieces.body[static_cast<std::size_t>(deepest->piece)]);
  const Vec4& x = state.x[b];
  // Only the worst case: a slow surface that is moved through a bed touches many.
  report(fmt::format(
      "particle {} at ({:.3g}, {:.3g}, {:.3g}) m overlaps the surface \"{}\" by {:.3g} times the "
      "{} of its piece (limit dem.largest_overlap = {:.3g}); a slower impact or surface, a smaller "
      "step, a stiffer contact or less load may help{}{}",
      state.id[b], x.x, x.y, x.z, surfaces[static_cast<std::size_t>(deepest->surface)]->name, worst,
      has_corners(deepest->piece) ? "rounding radius" : "radius", parameters.largest_overlap,
      worst > 1 ? "; or is the stone behind the surface (opposite to its normal)?" : "",
      softness()));
}

}  // namespace trackbed::dem
