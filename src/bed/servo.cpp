// The servo, and why it is built so: docs/decisions/packing.md has the overshoot on springs of
// several stiffnesses for this form and simpler ones.
//
// With F the force of the stones on the plate, N, and F_t = pressure x area,
//   speed = gain v_max (F_t - F_recent)/F_t,  cut at v_max, m/s, downwards positive.
// Only what pushes up counts as force. No model of the bed's stiffness is in it: the same servo
// must do on loose stones and on a compacted bed.
// A bed that dilates while it is sheared pushes such a servo ahead of it: with 25 mm/s a gain of
// 1/16 leaves 40 % too much at v_max = 1 m/s (inputs/bed/direct_shear.toml measured 60 %). There
// the speed is learnt as well (an integral term),
//   speed = drift + e,   d drift/dt = e/T,   e = gain v_max (F_t - F_recent)/F_t.
#include "trackbed/bed/servo.hpp"

#include <algorithm>
#include <cmath>

namespace trackbed::bed {

namespace {

constexpr double lead = 0.1;  // time constant of the servo over that of the mean
// Low enough for beds of 1 GPa/m; lower makes the plate too slow where stones give way.
constexpr double lowest_gain = 1.0 / 16;
// T over the time constant of the mean: slow enough not to swing on beds of 100 MPa/m.
constexpr double learning = 4;

// First-order low pass, exact for a force that is constant in the window.
//   mean += (value - mean)(1 - exp(-dt/T));  `windows` is dt/T. expm1 keeps the digits of small dt.
void follow(double& mean, double value, double windows) {
  mean += (value - mean) * -std::expm1(-windows);
}

}  // namespace

// What it knows of the bed's stiffness is kept.
void Servo::aim() { state_.steady_for = state_.low_for = state_.drift = 0; }

void Servo::rest() { state_ = {}; }

// Two means: `recent` steers, since a lag as long as the whole mean would make the plate swing;
// `mean` is what the pressure is judged by.
// Under vibration blows of several times the target alternate with none: cut at 1 they would
// balance in time instead of force, so the mean steers, too.
void Servo::feel(const ServoParameters& p, double dt, double force, bool vibrates) {
  follow(state_.recent, force, dt / ((vibrates ? 1 : lead) * p.average));
  follow(state_.mean, force, dt / p.average);
}

// Local; every rank has the same force and so the same motion.
double Servo::advance(const ServoParameters& p, double dt, double push, double target,
                      const Mode& mode) {
  State& s = state_;
  const double force = std::max(push, 0.0);  // stones cannot pull the plate
  const bool was_below = s.mean < target;
  feel(p, dt, force, mode.vibrates);
  // Each crossing from below halves the gain, so that swings die out on a bed of any stiffness; a
  // mean that stays too low for `hold` doubles it again, for stones that still yield.
  if (was_below && s.mean >= target) s.gain = std::max(s.gain / 2, lowest_gain);
  const double off = (s.mean - target) / target;
  s.steady_for = std::abs(off) <= p.tolerance ? s.steady_for + dt : 0;
  s.low_for = off < -p.tolerance ? s.low_for + dt : 0;
  if (s.low_for >= p.hold) s.gain = std::min(2 * s.gain, 1.0), s.low_for = 0;

  // Relative and cut at 1: far from the aim the plate moves with the speed of the deck, never more.
  const double error = std::clamp((target - s.recent) / target, -1.0, 1.0);
  const double most = p.speed, correction = s.gain * most * error;
  if (mode.follows) s.drift += correction * dt / (learning * p.average);
  s.drift = std::clamp(s.drift, -most, most);
  const double wanted = std::clamp(s.drift + correction, -most, most);
  const double step = p.acceleration * dt;
  // Braking, also to a stop before turning round, is free; gaining speed is limited.
  const double kept = wanted * s.speed > 0
                          ? std::copysign(std::min(std::abs(wanted), std::abs(s.speed)), wanted)
                          : 0;
  s.speed = kept + std::clamp(wanted - kept, -step, step);
  return s.speed * dt;
}

// Given from outside: the forces are followed all the same, for whoever judges the pressure.
void Servo::drive(const ServoParameters& p, double dt, double push, double way) {
  feel(p, dt, std::max(push, 0.0), false);
  state_.speed = way / dt;
}

// The state, listed once: speed, recent, mean, gain, steady_for, low_for, drift.
Servo::Row Servo::row() const {
  const State& s = state_;
  return {s.speed, s.recent, s.mean, s.gain, s.steady_for, s.low_for, s.drift};
}

void Servo::set(const Row& r) { state_ = {r[0], r[1], r[2], r[3], r[4], r[5], r[6]}; }

}  // namespace trackbed::bed
