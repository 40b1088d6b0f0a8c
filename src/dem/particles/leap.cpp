// Particles that move farther in one sub-step than contacts can detect (tunnelling). Overlaps are
// evaluated at the positions at the end of a sub-step, and a ball overlaps a plate as long as its
// centre is within its radius: a particle that moves farther at once may pass a plate or another
// particle without a contact. This is impossible if its travel in a sub-step, with that of the
// fastest surface, is at most its smallest radius: at the first evaluation its centre is still on
// its own side, and two particles have at most both radii between their centres.
//
// This limit excludes no resolved motion: on a contact that allows the step, dt = s sqrt(m/k) with
// s < 1, an impact at that speed would be deeper than the radius over s. Rejected: contacts along
// the path (continuous detection), which would need a law of their own for impacts that no law here
// resolves.
//
// Cost: one pass over particles in a window, of some ns each.
#include <fmt/format.h>

#include <algorithm>

#include "dem/particles/impl.hpp"

namespace trackbed::dem {

namespace {

// m, of a piece at full size; of a fragment at its present size.
double smallest_radius(const State& state, const Shapes& shapes, std::size_t b) {
  return shapes.least_radius(state.shape[b]) *
         (state.is_fragment(b) ? state.scale_now(b) : state.scale[b]);
}

}  // namespace

// The worst case of this rank. Spin moves the surface of particles that are not balls.
std::optional<FastParticle> Particles::Impl::fast_particle(double dt, double surface_travel) const {
  if (surfaces.empty() && population < 2) return {};
  std::optional<FastParticle> worst;
  for (std::size_t b = 0; b < state.own; ++b) {
    double speed = state.v[b].vec3().norm();
    if (!shapes.only_spheres()) speed += state.w[b].vec3().norm() * radius(b);
    const double travel = speed * dt + surface_travel, least = smallest_radius(state, shapes, b);
    if (travel > least && (!worst || travel * worst->radius > worst->travel * least))
      worst = FastParticle{state.id[b], travel, least};
  }
  return worst;
}

std::optional<FastParticle> Particles::fast_particle(double dt) const {
  return impl_->fast_particle(dt, 0);
}

// Once in a window: within one, speeds change by contacts that are detected.
void Particles::Impl::check_tunnelling(const SubStep& step) {
  double surface = 0;  // m, of the fastest node
  for (const double travel : surface_travel) surface = std::max(surface, travel / step.count);
  if (const std::optional<FastParticle> far = fast_particle(step.dt, surface))
    report(
        fmt::format("particle {} may approach a neighbour or a surface by {:.3g} m in a sub-step "
                    "of {:.3g} s, which is more than its smallest radius of {:.3g} m: a contact "
                    "may be missed; use smaller sub-steps (time.step, dem.safety) or lower speeds",
                    far->id, far->travel, step.dt, far->radius));
}

}  // namespace trackbed::dem
