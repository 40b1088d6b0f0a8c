// Vehicles on a single span against a modal solution of the beam, integrated independently here:
//   q_n'' + w_n^2 q_n = (2/(m L)) sin(n pi x_w/L) (-F),   w_n = (n pi/L)^2 sqrt(E I/m),
//   rail at x: sum q_n sin(n pi x/L);  F = k_c (rail - wheel), N, x_w = v t,
// with the equations of motion of the masses, by the Runge-Kutta method of fourth order with
// negligible error of the step.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "support/verified.hpp"
#include "trackbed/core/types.hpp"
#include "verify/track/lines.hpp"

namespace trackbed::track::span_test {
namespace {

constexpr double young = 2.87e9, inertia = 2.90, mass = 2303, length = 25;  // Yang and Yau's span
constexpr double speed = 100 / 3.6, duration = 0.9;                         // m/s, s
constexpr double body = 5000, wheelset = 750, spring = 1595e3, damper = 10e3, contact = 50e6;
constexpr int modes = 15;

// Heights and rates: modes, then body, then wheelset.
using State = Eigen::Matrix<double, modes + 2, 2>;

// Position of the wheel: at constant speed, and braking from 0.2 to 0.7 s.
using Place = double (*)(double);
constexpr double braked = 12, begin = 0.2, end = 0.7;  // m/s, s
double evenly(double time) { return speed * time; }
double braking(double time) {
  const double in = std::clamp(time, begin, end) - begin, last = std::max(time - end, 0.0);
  return speed * (time - last) - (speed - braked) / (end - begin) * in * in / 2 + braked * last;
}

TrainParameters motion_of(Place place) {
  TrainParameters motion{.vehicles = {"own"}, .speed = speed, .start = 0};
  if (place == braking) motion.times = {begin, end}, motion.speeds = {speed, braked};
  return motion;
}

double wave(int mode, double x) { return std::sin((mode + 1) * std::numbers::pi * x / length); }

State rate(const State& s, double x) {
  const double base =
      std::pow(std::numbers::pi / length, 2) * std::sqrt(young * inertia / mass);  // rad/s
  double rail = 0;
  for (int n = 0; n < modes; ++n) rail += s(n, 0) * wave(n, x);
  const double force = contact * std::max(0.0, rail - s(modes + 1, 0));
  const double between =
      spring * (s(modes + 1, 0) - s(modes, 0)) + damper * (s(modes + 1, 1) - s(modes, 1));
  State d;
  d.col(0) = s.col(1);
  for (int n = 0; n < modes; ++n)
    d(n, 1) =
        -std::pow((n + 1) * (n + 1) * base, 2) * s(n, 0) - 2 / (mass * length) * wave(n, x) * force;
  d(modes, 1) = between / body - gravity;
  d(modes + 1, 1) = (force - between) / wheelset - gravity;
  return d;
}

struct Crossing {
  std::vector<double> rail, wheel, body;  // m, mid-span, downwards; N; m; every 2 ms
};

Crossing by_modes(Place place = evenly) {
  constexpr double step = 2e-5;
  State s = State::Zero();
  s(modes + 1, 0) = -(body + wheelset) * gravity / contact;
  s(modes, 0) = s(modes + 1, 0) - body * gravity / spring;
  Crossing found;
  for (int i = 1; i <= std::lround(duration / step); ++i) {
    const double t = (i - 1) * step;
    const double halfway = place(t + step / 2);
    const State a = rate(s, place(t)), b = rate(s + step / 2 * a, halfway),
                c = rate(s + step / 2 * b, halfway), d = rate(s + step * c, place(t + step));
    s += step / 6 * (a + 2 * b + 2 * c + d);
    if (i % 100 != 0) continue;
    double middle = 0, below = 0;
    for (int n = 0; n < modes; ++n) {
      middle -= s(n, 0) * wave(n, length / 2);
      below += s(n, 0) * wave(n, place(i * step));
    }
    found.rail.push_back(middle);
    found.wheel.push_back(contact * std::max(0.0, below - s(modes + 1, 0)));
    found.body.push_back(s(modes, 0));
  }
  return found;
}

Crossing by_passage(double step, Place place = evenly) {
  const Line line(span(young, inertia, mass));
  VehicleParameters v;
  v.name = "own";
  v.kind = VehicleKind::sprung;
  v.length = 1;
  v.body_mass = body, v.wheelset_mass = wheelset;
  v.primary_stiffness = spring, v.primary_damping = damper;
  const TrainParameters motion = motion_of(place);
  const Train train(motion, {v}, 1);
  WheelRailParameters law;
  law.law = WheelRailLaw::linear;
  law.stiffness = contact;
  Passage passage(line, train, WheelRail(law), Irregularity({}, length), motion,
                  {.step = step, .duration = duration});
  const auto every = std::lround(2e-3 / step);
  Crossing found;
  for (int i = 1; i <= std::lround(duration / step); ++i) {
    passage.advance();
    if (i % every != 0) continue;
    found.rail.push_back(-passage.rail_displacement(length / 2));
    found.wheel.push_back(passage.wheel_force(0));
    found.body.push_back(passage.train_motion().displacement[0]);
  }
  return found;
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

// The deflection under a force is a sum of 1/n^4 over odd n: that beyond fifteen modes is 4e-5.
const verified::Tolerance beyond{1e-7, "modes beyond fifteen: 4e-5 of 2.4 mm"};
const verified::Tolerance in_contact{5, "modes beyond fifteen, 1e-7 m, times 50 MN/m"};
const verified::Tolerance order{
    0.05, "second order; wheelset on its contact, 41 Hz: (omega dt)^2 / 4 = 0.017 at the coarsest"};

// A body on spring and damper, the wheelset below it on a linear contact. Steps of 0.1 ms.
TEST(SprungMass, WithAnUnsprungMassOnASpan) {
  const Crossing reference = by_modes(), found = by_passage(1e-4);
  const auto most = [](const std::vector<double>& v) {
    return *std::max_element(v.begin(), v.end());
  };
  verified::near("largest at mid-span", "m", most(found.rail), most(reference.rail), beyond);
  verified::near("largest wheel force", "N", most(found.wheel), most(reference.wheel), in_contact);
  verified::below("mid-span, root mean square of the difference", "m",
                  distance(found.rail, reference.rail), beyond);
  verified::below("wheel force, root mean square of the difference", "N",
                  distance(found.wheel, reference.wheel), in_contact);
}

// Of the body, which is not affected by the highest modes of the span that no step resolves.
TEST(SprungMass, IsOfSecondOrderInTheStep) {
  const Crossing a = by_passage(1e-3), b = by_passage(5e-4), c = by_passage(2.5e-4);
  verified::near("order from steps of 1, 0.5, 0.25 ms, body", "-",
                 std::log2(distance(a.body, b.body) / distance(b.body, c.body)), 2, order);
  verified::below("body against the sum of modes, steps of 0.25 ms, root mean square", "m",
                  distance(c.body, by_modes().body),
                  {4e-7, "modes beyond fifteen, 1e-7 m, with dynamic amplification"});
}

// Braking changes the position of the wheel over time.
TEST(SprungMass, BrakingOnASpan) {
  const Crossing reference = by_modes(braking), fine = by_passage(1e-4, braking);
  verified::above("difference to constant speed, mid-span, root mean square", "m",
                  distance(reference.rail, by_modes().rail),
                  {1e-4, "separates: braking has an effect"});
  verified::below("mid-span, root mean square of the difference", "m",
                  distance(fine.rail, reference.rail), beyond);
  verified::below("wheel force, root mean square of the difference", "N",
                  distance(fine.wheel, reference.wheel), in_contact);
  const Crossing a = by_passage(1e-3, braking), b = by_passage(5e-4, braking),
                 c = by_passage(2.5e-4, braking);
  verified::near("order from steps of 1, 0.5, 0.25 ms, body", "-",
                 std::log2(distance(a.body, b.body) / distance(b.body, c.body)), 2, order);
}

// A constant force on the same span, its first mode against the closed form
//   q = (2 P/(m L)) (sin(W t) - (W/w) sin(w t))/(w^2 - W^2),  W = pi v/L:
// root mean square of the difference over the passage, m.
// While braking: the modal equation by the Runge-Kutta method of fourth order with small steps.
class FirstMode {
 public:
  explicit FirstMode(Place place) : place_(place) {}
  // m, at increasing times.
  double at(double time) {
    const double wave_number = std::numbers::pi / length;
    const double own = wave_number * wave_number * std::sqrt(young * inertia / mass);
    const auto rate = [&](const Eigen::Vector2d& q, double t) {
      return Eigen::Vector2d(
          q[1], 2e5 / (mass * length) * std::sin(wave_number * place_(t)) - own * own * q[0]);
    };
    const auto parts = std::lround((time - time_) / 2.5e-5);
    const double h = (time - time_) / static_cast<double>(parts);
    for (auto i = parts; i > 0; --i, time_ += h) {
      const Eigen::Vector2d a = rate(q_, time_), b = rate(q_ + h / 2 * a, time_ + h / 2),
                            c = rate(q_ + h / 2 * b, time_ + h / 2),
                            d = rate(q_ + h * c, time_ + h);
      q_ += h / 6 * (a + 2 * b + 2 * c + d);
    }
    return q_[0];
  }

 private:
  Place place_;
  double time_ = 0;
  Eigen::Vector2d q_ = Eigen::Vector2d::Zero();
};

double moving_force_error(int elements, double step, Place place = evenly) {
  LineParameters p = span(young, inertia, mass);
  p.track.spacing = length / 2;
  p.track.elements = elements / 2;
  const Line line(p);
  VehicleParameters v;
  v.name = "own";
  v.kind = VehicleKind::forces;
  v.length = 1;
  v.axles = {0}, v.loads = {1e5};
  const TrainParameters motion = motion_of(place);
  const Train train(motion, {v}, 1);
  Passage passage(line, train, WheelRail({}), Irregularity({}, length), motion,
                  {.step = step, .duration = duration});
  const double k = std::numbers::pi / length, drive = k * speed,
               own = k * k * std::sqrt(young * inertia / mass);
  double sum = 0;
  FirstMode slower(place);
  const auto steps = std::lround(duration / step);
  for (int i = 1; i <= steps; ++i) {
    passage.advance();
    const double at_one_speed =
        2e5 / (mass * length) *
        (std::sin(drive * passage.time()) - drive / own * std::sin(own * passage.time())) /
        (own * own - drive * drive);
    const double exact = place == evenly ? at_one_speed : slower.at(passage.time());
    sum += std::pow(-first_mode(line, elements, passage.line_motion().displacement) - exact, 2);
  }
  return std::sqrt(sum / static_cast<double>(steps));
}

// Cubic elements with consistent mass: fourth order in their length.
TEST(MovingForce, OrdersOnASpan) {
  const verified::Tolerance in_step{
      0.02, "second order; first mode, 30 rad/s: next term (omega dt)^2 = 4e-3 at the coarsest"};
  const auto check = [&](const std::string& of, Place place) {
    const double coarse = moving_force_error(40, 2e-3, place),
                 middle = moving_force_error(40, 1e-3, place),
                 fine = moving_force_error(40, 5e-4, place);
    verified::near("order in the step, 2 and 1 ms, " + of, "-", std::log2(coarse / middle), 2,
                   in_step);
    verified::near("order in the step, 1 and 0.5 ms, " + of, "-", std::log2(middle / fine), 2,
                   in_step);
    return middle;
  };
  check("40 elements", evenly);
  verified::below("first mode while braking, steps of 1 ms, root mean square", "m",
                  check("braking", braking),
                  {1e-6, "(omega dt)^2 / 24 of a phase of 27 rad, of 0.4 mm: 4e-7 m, twice"});
  // With four elements the error is larger than the order predicts.
  const double coarse = moving_force_error(8, 5e-5), middle = moving_force_error(12, 5e-5),
               fine = moving_force_error(16, 5e-5);
  const verified::Tolerance in_length{
      0.5, "fourth order; loads between nodes excite higher modes, which adds to it"};
  verified::near("order in element length, 8 and 12 elements", "-",
                 std::log(coarse / middle) / std::log(12.0 / 8), 4, in_length);
  verified::near("order in element length, 8 and 16 elements", "-", std::log2(coarse / fine), 4,
                 in_length);
}

}  // namespace
}  // namespace trackbed::track::span_test
