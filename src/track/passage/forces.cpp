// Forces over time. With h(s) the smooth step 3 s^2 - 2 s^3 from 0 to 1, t from the force's start:
//   harmonic: F(t) = size h(t/rise) sin(2 pi f t)
//   impact:   F(t) = size sin(pi t/length) for t < length
// Both start at zero, so that they are not part of the static equilibrium. A harmonic force that
// started at full amplitude would excite natural modes, which persist on an undamped rail.
// Half a sine is the force of a hammer with a soft tip; its spectrum has the first zero at
// 1.5/length.
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

// Positions are checked where the length of the track is known (model/track_rules/track_model.cpp).
void RailForce::declare(input::Section& s) {
  s.choice(
      "kind", kind, {"harmonic", "impact"},
      "Course of the force; harmonic: a sine without end; impact: half a sine, as of a hammer.");
  s.choice("side", side, {"left", "right"},
           "Rail on which the force acts (on a track with two rails).");
  s.number(
      "at", at, {.unit = "m", .at_least = 0},
      "x of the force, preferably at a rail node (a multiple of track.spacing / track.elements).");
  s.number("size", size, {.unit = "N", .usually_from = -1e6, .usually_to = 1e6},
           "Amplitude (harmonic) or peak (impact) of the force on one rail, downwards.");
  s.number("frequency", frequency, {.unit = "Hz", .above = 0, .usually_to = 5000},
           "Frequency of a harmonic force.");
  s.number("begin", begin, {.unit = "s", .at_least = 0}, "Time at which the force starts.");
  s.number("rise", rise, {.unit = "s", .at_least = 0},
           "Time in which a harmonic force reaches its amplitude.");
  s.number("length", length, {.unit = "s", .above = 0, .usually_to = 1},
           "Duration of an impact force.");
}

double RailForce::duration() const { return kind == ForceKind::impact ? length : 1 / frequency; }

double RailForce::force(double time) const {
  const double since = time - begin;
  if (since <= 0) return 0;
  if (kind == ForceKind::impact)
    return since < length ? size * std::sin(std::numbers::pi * since / length) : 0;
  const double grown = rise > 0 ? smooth(since / rise) : 1;
  return size * grown * std::sin(2 * std::numbers::pi * frequency * since);
}

}  // namespace trackbed::track
