// Forces of pieces on surfaces: the contacts found by mesh.hpp, the law of laws.hpp, and the way of
// each force to the nodes of its triangle.
#include <fmt/format.h>

#include <cmath>

#include "room.hpp"
#include "trackbed/core/exact_sum.hpp"

namespace trackbed::dem {

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
    at = a.patches.insert(at, Approach::Patch{patch, true, {}, 0, {}});
  at->touching = true;
  return *at;
}

}  // namespace

// Force and torque of one contact on particle `b`, the opposite on the surface's nodes, and both in
// the window's action.
void Particles::Room::touch_surface(Approach& a, const MeshContact& c, const SubStep& step) {
  const auto p = static_cast<std::size_t>(a.piece);
  const auto b = static_cast<std::size_t>(pieces.body[p]);
  const Vec4& piece = shapes.only_spheres() ? state.x[b] : pieces.x[p];
  Surface& surface = *surfaces[static_cast<std::size_t>(a.surface)];
  Approach::Patch& patch = patch_record(a, c.patch);
  patch.contact = c;
  const auto& nodes = surface.triangles[static_cast<std::size_t>(c.triangle)];
  Vec3 motion = Vec3::Zero();  // m, of the surface at the contact, over this sub-step
  for (int k = 0; k < 3; ++k)
    motion += c.weight[k] * surface.motion[static_cast<std::size_t>(nodes[k])];
  motion /= step.count;
  // From raw positions: which periodic image was taken must not change a bit.
  const Vec3 arm = (piece.vec3() - state.x[b].vec3()) + c.distance * c.normal;
  const Vec3 spin = state.w[b].vec3();
  const Vec3 v = state.v[b].vec3() + spin.cross(arm) - motion / step.dt;
  const Vec3& n = c.normal;
  // A surface does not spin: the contact turns with half the particle's spin about the normal.
  const Touch touch{
      n.x(), n.y(), n.z(), v.x(), v.y(), v.z(), piece.w - c.distance, 0.5 * spin.dot(n)};
  const Law& law = laws[static_cast<std::size_t>(a.law)];
  const Coefficients k = coefficients<true>(law, touch.delta, std::sqrt(mass(b)), piece.w);
  const Vec3 force = contact_force(k, touch, step.dt, patch.xi).vec3();
  const Vec3 torque = arm.cross(force);
  state.f[b].set(state.f[b].vec3() + force);
  state.t[b].set(state.t[b].vec3() + torque);
  load_nodes(surface, c, -force, step.share);
  action.force -= force;
  action.moment -= (state.x[b].vec3() + a.shift).cross(force) + torque;
  action.work -= force.dot(motion);
}

void Particles::Room::feel_surfaces(const SubStep& step) {
  thread_local std::vector<MeshContact> found;  // keeps its capacity: no allocation per step
  double worst = 0;
  for (Approach& a : approaches) {
    const auto p = static_cast<std::size_t>(a.piece);
    const auto b = static_cast<std::size_t>(pieces.body[p]);
    const Vec4& piece = shapes.only_spheres() ? state.x[b] : pieces.x[p];
    for (Approach::Patch& patch : a.patches) patch.touching = false;
    found.clear();
    meshes[static_cast<std::size_t>(a.surface)].touch(
        {piece.vec3() + a.shift, piece.w}, a.triangles,
        *surfaces[static_cast<std::size_t>(a.surface)], step.share, found);
    for (const MeshContact& c : found) {
      touch_surface(a, c, step);
      worst = std::max(worst, (piece.w - c.distance) / piece.w);
    }
    // What does not touch any more loses its history.
    std::erase_if(a.patches, [](const Approach::Patch& patch) { return !patch.touching; });
  }
  if (worst > parameters.largest_overlap)
    report(
        fmt::format("a particle overlaps a surface by {:.3g} of its radius (limit "
                    "dem.largest_overlap = {:.3g})",
                    worst, parameters.largest_overlap));
}

}  // namespace trackbed::dem
