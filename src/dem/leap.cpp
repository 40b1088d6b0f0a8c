// Particles that go farther in one sub-step than contacts can see. Overlaps are looked for where
// particles are at the end of a sub-step, and a ball overlaps a plate as long as its centre is
// within its radius: what goes farther than that at once may pass a plate or another particle
// without a contact. A particle whose way in a sub-step, with that of the fastest surface, is its
// smallest radius or less cannot: the first look finds it with its centre on its own side, and two
// of them with both radii between their centres at the most.
//
// Nothing else is lost by it: on a contact that allows the step, dt = s sqrt(m/k) with s < 1, an
// impact at that speed would be deeper than the radius over s. Rejected: contacts along the way
// (continuous detection), which would be a law of their own for impacts no law here resolves.
//
// Cost: one pass over particles in a window, of some ns each.
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "room.hpp"

namespace trackbed::dem {

namespace {

// m, smallest radius of a piece (of one with corners: its rounding), at full size.
double smallest_radius(const State& state, const Shapes& shapes, std::size_t b) {
  double least = std::numeric_limits<double>::infinity();
  const std::int64_t shape = state.shape[b];
  for (std::size_t k = shapes.begin(shape); k < shapes.end(shape); ++k)
    least = std::min(least, shapes.core(k).radius);
  return least * state.scale[b];
}

}  // namespace

// The worst of this rank. Spin moves the surface of what is not a ball.
std::optional<Leap> Particles::Room::leap(double dt, double surface_way) const {
  if (surfaces.empty() && population < 2) return {};
  std::optional<Leap> worst;
  for (std::size_t b = 0; b < state.own; ++b) {
    double speed = state.v[b].vec3().norm();
    if (!shapes.only_spheres()) speed += state.w[b].vec3().norm() * radius(b);
    const double way = speed * dt + surface_way, least = smallest_radius(state, shapes, b);
    if (way > least && (!worst || way * worst->radius > worst->way * least))
      worst = Leap{state.id[b], way, least};
  }
  return worst;
}

std::optional<Leap> Particles::leap(double dt) const { return room_->leap(dt, 0); }

// Once in a window: within one, speeds change by what contacts can see.
void Particles::Room::look_for_leaps(const SubStep& step) {
  double surface = 0;  // m, of the fastest node
  for (const double way : surface_way) surface = std::max(surface, way / step.count);
  if (const std::optional<Leap> far = leap(step.dt, surface))
    report(fmt::format(
        "particle {} and what it may hit come {:.3g} m closer in a sub-step of {:.3g} s, more than "
        "its smallest radius of {:.3g} m: it may pass without a contact; smaller steps or speeds "
        "help (time.step, dem.safety)",
        far->id, far->way, step.dt, far->radius));
}

}  // namespace trackbed::dem
