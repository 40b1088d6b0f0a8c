// The servo. docs/decisions/packing.md compares its overshoot on springs of several stiffnesses
// with that of simpler forms.
//
// With F the force of the stones on the plate, N, and F_t = pressure x area,
//   speed = gain v_max (F_t - F_recent)/F_t,  cut at v_max, m/s, downwards positive.
// Only upward force counts. The stiffness of the bed is not modelled, since the same servo must
// work on loose stones and on a compacted bed.
// A bed that dilates under shear displaces the plate continuously: at 25 mm/s a gain of 1/16 leaves
// a pressure 40 % too high with v_max = 1 m/s (inputs/bed/direct_shear.toml measured 60 %). In that
// case an integral term is added,
//   speed = drift + e,   d drift/dt = e/T,   e = gain v_max (F_t - F_recent)/F_t.
#include "trackbed/bed/servo.hpp"

#include <algorithm>
#include <cmath>

namespace trackbed::bed {

namespace {

constexpr double lead = 0.1;  // time constant of the servo over that of the mean
// Low enough for beds of 1 GPa/m; with a lower one the plate is too slow where stones yield.
constexpr double lowest_gain = 1.0 / 16;
// T over the time constant of the mean: long enough to avoid oscillation on beds of 100 MPa/m.
constexpr double integral_time = 4;

// First-order low pass, exact for a force that is constant in the window.
//   mean += (value - mean)(1 - exp(-dt/T));  `windows` is dt/T. expm1 keeps the digits of small dt.
void follow(double& mean, double value, double windows) {
  mean += (value - mean) * -std::expm1(-windows);
}

}  // namespace

// The gain, adapted to the stiffness of the bed, is kept.
void Servo::retarget() { state_.steady_for = state_.low_for = state_.drift = 0; }

void Servo::reset() { state_ = {}; }

// Two means: `recent` controls the speed, since a lag as long as that of the whole mean would cause
// oscillation; `mean` is the measured pressure.
// Under vibration, impacts of several times the target alternate with zero force. A relative error
// cut at 1 would balance their durations instead of their forces, so the whole mean controls the
// speed.
void Servo::average_force(const ServoParameters& p, double dt, double force, bool vibrates) {
  follow(state_.recent, force, dt / ((vibrates ? 1 : lead) * p.average));
  follow(state_.mean, force, dt / p.average);
}

// Local; every rank has the same force and so the same motion.
double Servo::advance(const ServoParameters& p, double dt, double force, double target,
                      const Mode& mode) {
  State& s = state_;
  const double compression = std::max(force, 0.0);  // stones cannot pull the plate
  const bool was_below = s.mean < target;
  average_force(p, dt, compression, mode.vibrates);
  // Each crossing from below halves the gain, so that oscillations decay on a bed of any stiffness;
  // a mean that stays too low for `hold` doubles it again, for stones that still yield.
  if (was_below && s.mean >= target) s.gain = std::max(s.gain / 2, lowest_gain);
  const double off = (s.mean - target) / target;
  s.steady_for = std::abs(off) <= p.tolerance ? s.steady_for + dt : 0;
  s.low_for = off < -p.tolerance ? s.low_for + dt : 0;
  if (s.low_for >= p.hold) s.gain = std::min(2 * s.gain, 1.0), s.low_for = 0;

  // Relative and cut at 1: far from the target the plate moves at the speed of the deck, never
  // faster.
  const double error = std::clamp((target - s.recent) / target, -1.0, 1.0);
  const double most = p.speed, correction = s.gain * most * error;
  if (mode.integral) s.drift += correction * dt / (integral_time * p.average);
  s.drift = std::clamp(s.drift, -most, most);
  const double wanted = std::clamp(s.drift + correction, -most, most);
  const double step = p.acceleration * dt;
  // Braking, also to a stop before a reversal, is not limited; acceleration is.
  const double kept = wanted * s.speed > 0
                          ? std::copysign(std::min(std::abs(wanted), std::abs(s.speed)), wanted)
                          : 0;
  s.speed = kept + std::clamp(wanted - kept, -step, step);
  return s.speed * dt;
}

// Prescribed motion: the forces are averaged all the same, for the measured pressure.
void Servo::drive(const ServoParameters& p, double dt, double force, double displacement) {
  average_force(p, dt, std::max(force, 0.0), false);
  state_.speed = displacement / dt;
}

void Servo::archive(io::Archive& a) {
  State& s = state_;
  a("speed", s.speed, {"m/s", "in the last window, towards the stones"});
  a("recent_force", s.recent, {"N", "of the stones, averaged over a tenth of the time constant"});
  a("mean_force", s.mean, {"N", "of the stones, averaged over the time constant"});
  a("gain", s.gain, {"-", "adaptive gain, initially 1"});
  a("steady_for", s.steady_for, {"s", "for which the mean force has been within the tolerance"});
  a("too_low_for", s.low_for, {"s", "for which the mean force has been below the tolerance"});
  a("integral_speed", s.drift, {"m/s", "integral term of the speed"});
}

}  // namespace trackbed::bed
