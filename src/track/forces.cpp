// Forces in time. With h(s) the smooth step 3 s^2 - 2 s^3 from 0 to 1, t from the force's begin:
//   harmonic: F(t) = size h(t/rise) sin(2 pi f t)
//   impact:   F(t) = size sin(pi t/length) while it lasts
// Both begin at zero, so that equilibrium before them is one without them. A harmonic force that
// began at full size would shake the track's own modes, which an undamped rail keeps for ever.
// Half a sine is what a hammer with a soft tip does; its spectrum has the first zero at 1.5/length.
#include "trackbed/track/forces.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace trackbed::track {

namespace {

double smooth(double s) {
  const double c = std::clamp(s, 0.0, 1.0);
  return c * c * (3 - 2 * c);
}

}  // namespace

// Places are checked where the length of the track is known (app/track_model.cpp).
void RailForce::declare(input::Section& s) {
  s.choice("kind", kind, {"harmonic", "impact"},
           "harmonic: goes on as a sine; impact: half a sine, as of a hammer.");
  s.choice("side", side, {"left", "right"}, "Rail it acts on, of two.");
  s.number("at", at, {.unit = "m", .at_least = 0},
           "x of the rail it acts on; best a node of the rail (see passage.points).");
  s.number("size", size, {.unit = "N", .usually_from = -1e6, .usually_to = 1e6},
           "Amplitude or peak, downwards, on one rail.");
  s.number("frequency", frequency, {.unit = "Hz", .above = 0, .usually_to = 5000}, "Harmonic.");
  s.number("begin", begin, {.unit = "s", .at_least = 0}, "Time at which it begins.");
  s.number("rise", rise, {.unit = "s", .at_least = 0},
           "Time in which a harmonic force grows to its size.");
  s.number("length", length, {.unit = "s", .above = 0, .usually_to = 1}, "Time an impact takes.");
}

double RailForce::lasts() const { return kind == ForceKind::impact ? length : 1 / frequency; }

double RailForce::force(double time) const {
  const double since = time - begin;
  if (since <= 0) return 0;
  if (kind == ForceKind::impact)
    return since < length ? size * std::sin(std::numbers::pi * since / length) : 0;
  const double grown = rise > 0 ? smooth(since / rise) : 1;
  return size * grown * std::sin(2 * std::numbers::pi * frequency * since);
}

}  // namespace trackbed::track
