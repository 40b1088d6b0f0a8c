// Seat loads on sleepers without rail and train: each is a mass on its ballast spring,
//   m u'' + c u' + k u = -Q(t),
// integrated here by the Runge-Kutta method of fourth order with negligible error; it starts in
// static equilibrium under Q(0).
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "support/verified.hpp"
#include "verify/track/lines.hpp"

namespace trackbed::track::seats_test {
namespace {

constexpr std::size_t watched = 20;
constexpr double duration = 0.4;  // s

// Bogies of a locomotive at 200 km/h; the first axle starts half a metre before the sleeper.
SeatLoad load() {
  SeatLoadParameters p;
  p.axles = {0, 2.8, 9.0, 11.8};
  p.speed = 200 / 3.6;
  p.start = 11.5;
  return SeatLoad(p, 0.6, 41);
}

LineParameters sleepers(Dimension dimension) {
  LineParameters p;
  p.track.dimension = dimension;
  p.track.length = 24;
  p.track.run_in = 0;
  p.ballast.damping = 20e3;
  p.pads = false;
  return p;
}

// m, every 2 ms.
std::vector<double> exact() {
  const LineParameters p = sleepers(Dimension::plane);
  const SeatLoad q = load();
  const double mass = p.track.sleeper_mass / 2, step = 1e-5, x = 0.6 * watched;
  const auto rate = [&](const Eigen::Vector2d& u, double t) {
    return Eigen::Vector2d(
        u[1], -(q.at(x, t) + p.ballast.damping * u[1] + p.ballast.stiffness * u[0]) / mass);
  };
  Eigen::Vector2d u(-q.at(x, 0) / p.ballast.stiffness, 0);
  std::vector<double> found;
  for (int i = 0; i < std::lround(duration / step); ++i) {
    const double t = i * step;
    const Eigen::Vector2d a = rate(u, t), b = rate(u + step / 2 * a, t + step / 2),
                          c = rate(u + step / 2 * b, t + step / 2),
                          d = rate(u + step * c, t + step);
    u += step / 6 * (a + 2 * b + 2 * c + d);
    if ((i + 1) % 200 == 0) found.push_back(u[0]);
  }
  return found;
}

struct Found {
  std::vector<double> left, right;  // m; the same of a plane track
  double rail = 0;                  // m, largest displacement
};

Found computed(const LineParameters& p, double step) {
  const Line line(p);
  const TrainParameters none{.vehicles = {}, .speed = 1, .start = 0};
  const Train train(none, {}, 2, p.track.wheel_gauge());
  Passage passage(line, train, WheelRail({}), Irregularity({}, 24), none,
                  {.step = step, .duration = duration}, {}, load());
  const auto every = std::lround(2e-3 / step);
  Found found;
  for (int i = 1; i <= std::lround(duration / step); ++i) {
    passage.advance();
    found.rail = std::max(found.rail, std::abs(passage.rail_displacement(12)));
    if (i % every != 0) continue;
    const Vector& u = passage.line_motion().displacement;
    found.left.push_back(u[line.sleeper_unknown(watched, 0)]);
    found.right.push_back(u[line.sleeper_unknown(watched, line.sides() - 1)]);
  }
  return found;
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return std::sqrt(sum / static_cast<double>(a.size()));
}

// The oscillation at w = 632 rad/s is a tenth of 1.2 mm.
TEST(SeatLoads, MoveEachSleeperAsAMassOnASpring) {
  const std::vector<double> reference = exact();
  const auto error = [&](double step) {
    return distance(computed(sleepers(Dimension::plane), step).left, reference);
  };
  verified::above("largest displacement", "m",
                  -*std::min_element(reference.begin(), reference.end()),
                  {1e-3, "separates: the sleeper moves"});
  const double coarse = error(5e-4), middle = error(2.5e-4), fine = error(1e-4);
  verified::below("root mean square of the difference, steps of 0.1 ms", "m", fine,
                  {5e-8, "(omega dt)^2 / 12 = 3e-4 of an oscillation of 0.12 mm: 4e-8 m"});
  const verified::Tolerance order{0.1,
                                  "second order; next term (omega dt)^2 / 4 = 0.025 at 0.5 ms"};
  verified::near("order from steps of 0.5 and 0.25 ms", "-", std::log2(coarse / middle), 2, order);
  verified::near("order from steps of 0.25 and 0.1 ms", "-",
                 std::log(middle / fine) / std::log(2.5), 2, order);
}

// Under equal loads a whole sleeper moves like its half; stiff bending sleepers as well.
TEST(SeatLoads, EqualLoadsOnBothRails) {
  const Found plane = computed(sleepers(Dimension::plane), 5e-4),
              space = computed(sleepers(Dimension::space), 5e-4);
  const verified::Limit rounding{2e-16, "rounding of 1 mm, 2e-19 m, in each of 800 steps"};
  verified::below("left end, difference to a half", "m", distance(space.left, plane.left),
                  rounding);
  verified::below("right end, difference to a half", "m", distance(space.right, plane.left),
                  rounding);
  verified::below("rail", "m", space.rail, rounding);
  LineParameters bending = sleepers(Dimension::plane);
  bending.track.sleeper.model = SleeperModel::beam;
  bending.track.sleeper.young *= 1e5;
  verified::below("very stiff bending sleepers, difference", "m",
                  distance(computed(bending, 5e-4).left, plane.left),
                  {1.2e-9, "bending, a tenth of 1.2 mm, over 1e5"});
}

}  // namespace
}  // namespace trackbed::track::seats_test
