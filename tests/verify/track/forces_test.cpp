// Forces on the rail without a vehicle: receptances of a rail on discrete supports.
//
// Reference: an infinite Euler-Bernoulli rail whose supports are forces. Its own response to a unit
// force e^(i w t) is
//   G(r) = -(e^(-k r) + i e^(-i k r))/(4 E I k^3),   k^4 = m w^2/(E I),   r the distance, m,
// the force of a support is -Z w_j,  Z the stiffness of pad, sleeper and ballast in series:
//   1/Z = 1/(k_p + i w c_p) + 1/(k_b + i w c_b - M w^2),
// so that w(x) = G(x - x_0) - sum_j G(x - x_j) Z w_j, and the w_j follow from as many equations
// (Mead 1970, doi:10.1016/0022-460X(70)90062-1, by wave numbers).
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <complex>
#include <numbers>

#include "support/verified.hpp"
#include "verify/track/lines.hpp"

namespace trackbed::track::forces_test {
namespace {

using Complex = std::complex<double>;

// Sleepers over 60 m, one of them at 30 m. Waves in the rail decay within a few metres.
LineParameters discrete() {
  LineParameters p;
  p.rail.theory = BeamTheory::euler;
  p.track.length = 60;
  p.track.run_in = 0;
  p.track.ends = RailEnds::free;
  return p;
}

// m/N, of the point at `x` under a force at `x`; supports every 0.6 m from 0 to 60 m.
Complex exact(const LineParameters& p, double x, double frequency) {
  const Complex i(0, 1);
  const double w = 2 * std::numbers::pi * frequency;
  const Beam beam = beam_of(p.rail);
  const double k = std::pow(beam.mass * w * w / beam.bending_stiffness, 0.25);
  const auto green = [&](double r) {
    return -(std::exp(-k * r) + i * std::exp(-i * k * r)) /
           (4 * beam.bending_stiffness * k * k * k);
  };
  const Complex pad = p.pad.stiffness + i * w * p.pad.damping;
  const Complex below = p.ballast.stiffness + i * w * p.ballast.damping -
                        w * w * p.track.sleeper_mass / static_cast<double>(p.track.rails);
  const Complex support = pad * below / (pad + below);
  const Eigen::Index n = std::lround(p.track.length / p.track.spacing) + 1;
  Eigen::MatrixXcd matrix = Eigen::MatrixXcd::Identity(n, n);
  Eigen::VectorXcd right(n);
  for (Eigen::Index a = 0; a < n; ++a) {
    const double at = static_cast<double>(a) * p.track.spacing;
    right[a] = green(std::abs(at - x));
    for (Eigen::Index b = 0; b < n; ++b)
      matrix(a, b) += green(std::abs(static_cast<double>(a - b)) * p.track.spacing) * support;
  }
  const Eigen::VectorXcd supported = matrix.partialPivLu().solve(right);
  return green(0) - support * (right.transpose() * supported)(0);
}

struct Motion {
  std::vector<double> force, rail;  // N, m, downwards, at the end of each step
};

// A passage without a train.
Motion under(const RailForce& force, double step, double duration) {
  const Line line(discrete());
  const TrainParameters motion{.vehicles = {}, .speed = 1, .start = 0};
  const Train train(motion, {}, 2);
  Passage passage(line, train, WheelRail({}), Irregularity({}, 60), motion,
                  {.step = step, .duration = duration, .forces = {force}});
  Motion found;
  for (auto i = std::lround(duration / step); i > 0; --i) {
    passage.advance();
    found.force.push_back(passage.rail_force(0));
    found.rail.push_back(-passage.rail_displacement(force.at));
  }
  return found;
}

// Ratio of both Fourier transforms, of motions that start and end at rest.
Complex receptance(const Motion& motion, double step, double frequency) {
  Complex rail = 0, force = 0;
  for (std::size_t k = 0; k < motion.rail.size(); ++k) {
    const Complex turn =
        std::polar(1.0, -2 * std::numbers::pi * frequency * static_cast<double>(k + 1) * step);
    rail += motion.rail[k] * turn;
    force += motion.force[k] * turn;
  }
  return rail / force;
}

RailForce hammer(double at) {
  RailForce force;
  force.kind = ForceKind::impact;
  force.at = at;
  force.size = 10e3;
  force.length = 1e-3;
  return force;
}

// The error of a frequency in steps dt is (w dt)^2/12; near resonances amplitude and phase change
// quickly with it. Elements of 0.15 m: (k h)^4/720 = 4e-5 at 400 Hz.
verified::Tolerance of_step(double frequency, double step) {
  return {std::pow(2 * std::numbers::pi * frequency * step, 2) / 2,
          "(omega dt)^2 / 12 of the frequency, up to six times near resonances"};
}

// An impact contains all frequencies.
TEST(Receptance, OfARailOnSleepers) {
  constexpr double step = 2.5e-5;
  for (const auto& [at, where] : {std::pair{30.0, "on a sleeper"}, {30.3, "in mid-bay"}}) {
    const Motion motion = under(hammer(at), step, 0.4);
    for (const double frequency : {40.0, 100.0, 200.0, 400.0}) {
      const Complex reference = exact(discrete(), at, frequency);
      const Complex found = receptance(motion, step, frequency);
      verified::near(fmt::format("amplitude {} at {:g} Hz", where, frequency), "m/N",
                     std::abs(found), std::abs(reference),
                     of_step(frequency, step).of(std::abs(reference)));
      verified::near(fmt::format("phase {} at {:g} Hz", where, frequency), "rad", std::arg(found),
                     std::arg(reference), of_step(frequency, step));
    }
  }
}

// Differences of three steps, without the error of the elements.
TEST(Receptance, IsOfSecondOrderInTheStep) {
  constexpr double frequency = 300, at = 30.3;
  const auto found = [&](double step) {
    return receptance(under(hammer(at), step, 0.2), step, frequency);
  };
  const Complex coarse = found(2e-4), middle = found(1e-4), fine = found(5e-5);
  verified::near("order from steps of 0.2, 0.1, 0.05 ms", "-",
                 std::log2(std::abs(coarse - middle) / std::abs(middle - fine)), 2,
                 {0.1, "second order; next term (omega dt)^2 / 3 = 5 % at the coarsest"});
}

// A sine that grows over ten periods; sine and cosine are fitted over the last five.
TEST(HarmonicForce, ReachesTheReceptance) {
  constexpr double frequency = 100, step = 5e-5, at = 30;
  RailForce force;
  force.at = at;
  force.frequency = frequency;
  force.rise = 10 / frequency;
  const Motion motion = under(force, step, 0.4);
  const auto last = static_cast<std::size_t>(std::lround(5 / frequency / step));
  const auto fitted = [&](const std::vector<double>& values) {
    Complex sum = 0;
    for (std::size_t k = values.size() - last; k < values.size(); ++k)
      sum += values[k] *
             std::polar(1.0, -2 * std::numbers::pi * frequency * static_cast<double>(k + 1) * step);
    return sum * 2.0 / static_cast<double>(last);
  };
  const Complex reference = exact(discrete(), at, frequency);
  const Complex found = fitted(motion.rail) / fitted(motion.force);
  verified::near(
      "amplitude of the force", "N", std::abs(fitted(motion.force)), 1e3,
      {2e-7, "rounding of times, 1e-13 s after 8000 steps, times omega: 6e-11, three times"});
  verified::near("amplitude per force at 100 Hz", "m/N", std::abs(found), std::abs(reference),
                 of_step(frequency, step).of(std::abs(reference)));
  verified::near("phase at 100 Hz", "rad", std::arg(found), std::arg(reference),
                 of_step(frequency, step));
}

}  // namespace
}  // namespace trackbed::track::forces_test
