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
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "plate.hpp"
#include "trackbed/bed/bed.hpp"
#include "trackbed/core/error.hpp"

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

// Larger than the bed, so that no stone finds its edge; the pressure counts the bed's area alone.
// The order of the edges makes the normal point down, to the stones.
Platen::Platen(const PlatenParameters& parameters, const Container& container, int material)
    : parameters_(parameters), area_(container.area()) {
  const Footprint outside =
      Footprint{container.low, container.high}.grown(beyond + container.beside);
  const Vec3 size = outside.high - outside.low;
  surface_ = plate("platen", material, outside.low, Vec3(0, size.y(), 0), Vec3(size.x(), 0, 0));
}

Surface& Platen::surface() { return surface_; }
double Platen::pressure() const { return state_.mean / area_; }
double Platen::z() const { return state_.z; }
bool Platen::steady() const { return state_.steady_for >= parameters_.hold; }

// What the servo knows of the bed's stiffness is kept.
void Platen::aim(double pressure, bool follows) {
  parameters_.pressure = pressure;
  follows_ = follows;
  state_.steady_for = state_.low_for = state_.drift = 0;
}

// With numbers: whether to wait longer or to change the bed is the user's to judge.
std::string Platen::shortfall() const {
  if (steady()) return {};
  return fmt::format(
      "the averaged pressure of the platen is {:.1f} kPa and was within {:g} % of {:g} kPa for "
      "{:.3g} s, not for {:g} s (platen.hold)",
      pressure() / 1e3, 100 * parameters_.tolerance, parameters_.pressure / 1e3, state_.steady_for,
      parameters_.hold);
}

// All nodes alike: the plate stays level.
void Platen::show(double motion) {
  for (Vec3& node : surface_.position) node.z() = state_.z;
  for (Vec3& node : surface_.motion) node = Vec3(0, 0, motion);
}

// A new state: what the servo knew of another bed means nothing.
void Platen::place(double z) {
  state_ = {};
  state_.z = z;
  show(0);
}

// m, upwards, in this window. x = A sin(2 pi f t) min(1, t f): the first period grows, since a jump
// of speed would be a blow. Where it stops it leaves the plate: the servo goes on from there.
double Platen::shake(double dt) {
  if (parameters_.vibration <= 0 || follows_) return 0;
  const double f = parameters_.frequency;
  const auto place = [&](double t) {
    return parameters_.vibration * std::sin(2 * std::numbers::pi * f * t) * std::min(1.0, t * f);
  };
  const double before = place(state_.shaken);
  state_.shaken += dt;
  return place(state_.shaken) - before;
}

// Local; every rank has the same force and so the same motion.
void Platen::advance(double dt, double force_up) {
  State& s = state_;
  const double target = parameters_.pressure * area_;
  const double force = std::max(force_up, 0.0);  // stones cannot pull the plate down
  // Two means: `recent` steers, since a lag as long as the whole mean would make the plate swing;
  // `mean` is what the pressure is judged by.
  const bool was_below = s.mean < target;
  // Under vibration blows of several times the target alternate with none: cut at 1 they would
  // balance in time instead of force, so the mean steers, too.
  const bool vibrates = parameters_.vibration > 0 && !follows_;
  follow(s.recent, force, dt / ((vibrates ? 1 : lead) * parameters_.average));
  follow(s.mean, force, dt / parameters_.average);
  // Each crossing from below halves the gain, so that swings die out on a bed of any stiffness; a
  // mean that stays too low for `hold` doubles it again, for stones that still yield.
  if (was_below && s.mean >= target) s.gain = std::max(s.gain / 2, lowest_gain);
  const double off = (s.mean - target) / target;
  s.steady_for = std::abs(off) <= parameters_.tolerance ? s.steady_for + dt : 0;
  s.low_for = off < -parameters_.tolerance ? s.low_for + dt : 0;
  if (s.low_for >= parameters_.hold) s.gain = std::min(2 * s.gain, 1.0), s.low_for = 0;

  // Relative and cut at 1: far from the aim the plate moves with the speed of the deck, never more.
  const double error = std::clamp((target - s.recent) / target, -1.0, 1.0);
  const double most = parameters_.speed, correction = s.gain * most * error;
  if (follows_) s.drift += correction * dt / (learning * parameters_.average);
  s.drift = std::clamp(s.drift, -most, most);
  const double wanted = std::clamp(s.drift + correction, -most, most);
  const double step = parameters_.acceleration * dt;
  // Braking, also to a stop before turning round, is free; gaining speed is limited.
  const double kept = wanted * s.speed > 0
                          ? std::copysign(std::min(std::abs(wanted), std::abs(s.speed)), wanted)
                          : 0;
  s.speed = kept + std::clamp(wanted - kept, -step, step);
  const double motion = -s.speed * dt + shake(dt);
  show(motion);
  s.z += motion;
}

// The state, listed once: columns z (m), speed (m/s), recent, mean (N), gain, steady_for (s),
// low_for (s), drift (m/s), shaken (s).
// `save`, `load` and State name the same nine in the same order.
void Platen::save(io::File& file, const std::string& group, const par::Comm& comm) const {
  const std::array row{state_.z,          state_.speed,   state_.recent, state_.mean,  state_.gain,
                       state_.steady_for, state_.low_for, state_.drift,  state_.shaken};
  const std::span<const double> mine(row.data(), comm.root() ? row.size() : 0);
  file.write<double>(group + "/servo", mine, row.size(),
                     {"-",
                      "z (m), speed down (m/s), recent and mean force (N), gain, steady for (s), "
                      "too low for (s), learnt speed down (m/s), shaken for (s)"});
}

void Platen::load(const io::File& file, const std::string& group) {
  const auto row = file.read_all<double>(group + "/servo");
  if (row.size() != 9) throw RunError(group + "/servo does not hold the state of a platen");
  state_ = {row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8]};
  show(0);
}

}  // namespace trackbed::bed
