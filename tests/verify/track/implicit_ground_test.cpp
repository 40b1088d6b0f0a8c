// Sleepers on an implicit ground of elements: static against springs in series; in motion the
// order, the difference to explicit steps, and energy and balances with much longer steps.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "support/verified.hpp"
#include "verify/track/on_ground_scene.hpp"

namespace trackbed::model::implicit_ground_test {
namespace {

constexpr fem::Elastic clay{60e6, 0.3, 2000};

Model implicit(Model m, double step) {
  m.ground.integrator = fem::Integrator::newmark;
  m.ground.tolerance = 1e-10;
  m.track.passage.step = step;
  return m;
}

Model undamped(Model m) {
  m.track.line.ballast.damping = m.track.line.pad.damping = 0;
  return m;
}

// Whole sleepers on a ground in space, the left rail loaded.
Model wide(std::int64_t count) {
  Model m = model_of(count, clay);
  m.dimension = m.track.line.track.dimension = Dimension::space;
  m.ground = fem::box({0.6 * static_cast<double>(count), 3.6, 1.2}, {2 * count, 6, 3}, clay);
  m.ground.base = fem::Base::fixed;
  m.ground.sides = fem::Sides::roller;
  m.footing.length = 2.6, m.footing.y = 1.8, m.footing.rails = 2;
  return m;
}

Model with_bilinear_pads_and_gaps(Model m) {
  m.track.line.pad.bilinear_at = 2e-5, m.track.line.pad.bilinear_stiffness = 400e6;
  m.track.line.track.zones = {{.from = 4.7, .to = 6.1, .gap = 5e-5}};  // three sleepers
  return m;
}

void check_balance(const Pair& pair, const std::string& of) {
  const auto balance = pair.whole.below->balance();
  for (const char* name : {"force", "moment", "work"})
    verified::below("largest imbalance of " + std::string(name) + ", " + of, "-",
                    balance[name].get<double>(), rounding_of_sums);
  verified::below("height of the ground in the track's solve against its own, " + of, "-",
                  balance["height"].get<double>(),
                  {1e-9, "solver of the ground: 1e-10 of the forces of a step, ten times"});
}

// As for explicit grounds, H/(M A), with steps twenty times as long.
TEST(ImplicitGround, SpringAndColumnInSeries) {
  Pair pair(implicit(at_rest(model_of(1, clay)), 5e-3));
  pair.run(1.0);
  const double modulus = 60e6 * 0.7 / (1.3 * 0.4), area = 0.6 * 1.2, height = 1.2;
  const double force = pair.built.passage.ground_force(before);
  const double give = 1 / 100e6 + height / (modulus * area);
  verified::near("sleeper per force on the ground", "m/N", -sleeper(pair, before) / force, give,
                 almost_static.of(give));
}

// Every 0.8 ms: m, of a sleeper and of the ground below it, under a growing force of 50 Hz.
using Histories = std::array<std::vector<double>, 2>;
Histories shaken(Model m) {
  auto& force = m.track.passage.forces[0];
  force.kind = track::ForceKind::harmonic, force.frequency = 50, force.rise = 0.02;
  Pair pair(m);
  Histories found;
  for (int row = 0; row < 40; ++row) {
    pair.run(8e-4);
    found[0].push_back(sleeper(pair, before + 2));
    found[1].push_back(pair.built.passage.ground_below(before + 2).height);
  }
  return found;
}

TEST(ImplicitGround, IsOfSecondOrder) {
  const Model m = model_of(5, clay);
  const Histories a = shaken(implicit(m, 2e-4)), b = shaken(implicit(m, 1e-4)),
                  c = shaken(implicit(m, 5e-5));
  for (const std::size_t k : {0, 1}) {
    const std::string of = k == 0 ? "sleeper" : "ground";
    verified::near("order in the step, " + of, "-",
                   std::log2(distance(a[k], b[k]) / distance(b[k], c[k])), 2, second_order);
  }
}

// The errors of both are of second order, and so is their difference.
TEST(ImplicitGround, ExplicitAndImplicitConverge) {
  std::array<std::array<double, 2>, 2> apart{};
  double size = 0;
  for (const std::size_t fine : {0, 1}) {
    Model m = model_of(5, clay);
    m.track.passage.step = fine == 1 ? 2e-5 : 4e-5;
    const Histories other = shaken(m), own = shaken(implicit(m, m.track.passage.step));
    for (const std::size_t k : {0, 1}) {
      apart[fine][k] = distance(own[k], other[k]);
      size = std::max(size, distance(own[k], std::vector<double>(own[k].size())));
    }
  }
  for (const std::size_t k : {0, 1}) {
    const std::string of = k == 0 ? "sleeper" : "ground";
    verified::near("order of their difference in the step, " + of, "-",
                   std::log2(apart[0][k] / apart[1][k]), 2, second_order);
    verified::below("difference at 0.02 ms over the motion, " + of, "-", apart[1][k] / size,
                    {1e-4, "period errors of opposite sign: (omega dt)^2 / 8 = 8e-5 at 200 Hz"});
  }
}

// Without dampers track, ground and the springs between them follow one trapezoidal rule.
const verified::Limit solves{1e-7, "solver of the ground: 1e-10 in each of 800 steps, 8e-8"};

void check_energy(const Model& given, double step, int steps, const std::string& of,
                  const verified::Limit& most_off) {
  Pair pair(implicit(undamped(given), step));
  pair.run(given.track.passage.forces[0].length);
  const double after = pair.energy();
  double off = 0, in_ground = 0;
  for (int n = 0; n < steps; ++n) {
    pair.step();
    const auto now = pair.whole.below->energies(pair.built.passage);
    off = std::max(off, std::abs(pair.energy() - after));
    in_ground = std::max(in_ground, now.ground.kinetic + now.ground.elastic);
  }
  verified::above("largest fraction of the energy in the ground, " + of, "-", in_ground / after,
                  {0.05, "separates: the ground takes part"});
  verified::below("largest change of energy, " + of, "-", off / after, most_off);
  check_balance(pair, of);
}

TEST(ImplicitGround, KeepsEnergyInLongSteps) {
  Model m = model_of(5, clay);
  m.track.passage.step = 1;
  const double limit = Pair(m).whole.below->step();
  m.footing.rails = 2;
  m.track.passage.forces[0].length = 0.1;
  for (const double times : {10, 50}) {
    const double step = 0.1 / std::ceil(0.1 / (times * limit));
    check_energy(m, step, 800,
                 "steps " + std::to_string(std::lround(times)) + " times the explicit one", solves);
  }
}

TEST(ImplicitGround, KeepsEnergyOfTwoRails) {
  check_energy(wide(4), 1e-3, 400, "two rails", solves);
}

// Piecewise linear springs are integrated to second order, not exactly.
TEST(ImplicitGround, KeepsEnergyOfBilinearPadsAndGaps) {
  check_energy(with_bilinear_pads_and_gaps(model_of(5, clay)), 2e-5, 1000, "bilinear pads and gaps",
               corners);
}

// Sleepers on a soft ground, with steps as long as the closure of a gap.
TEST(ImplicitGround, ConvergesWithBilinearPadsAndGapsInLongSteps) {
  for (const bool two : {false, true}) {
    Model m = with_bilinear_pads_and_gaps(two ? wide(5) : model_of(5, {5e6, 0.3, 2000}));
    m.track.passage.forces[0].size = 500e3;
    Pair pair(implicit(m, 2.5e-3));
    pair.run(0.5);
    const track::Passage& passage = pair.built.passage;
    check_balance(pair, two ? "bilinear pads and gaps of two rails" : "bilinear pads and gaps");
    verified::below(
        two ? "iterations of Newton's method in a step, two rails"
            : "iterations of Newton's method in a step",
        "-", static_cast<double>(passage.iterations()) / static_cast<double>(passage.steps()),
        {6, "one, and one for each group of pads and gaps that change: 2 or 3"});
  }
}

// Two axles of a bogie over the ground, with wheel contacts solved together with the ground.
TEST(ImplicitGround, WheelContactsConvergeWithTheGround) {
  Model m = model_of(5, {5e6, 0.3, 2000});
  m.track.passage.forces = {};
  m.track.train.vehicles = {"x2_bogie"};
  m.track.train.speed = 80, m.track.train.start = 0;
  Pair pair(implicit(m, 1e-3));
  double most = 0;
  for (int n = 0; n < 120; ++n) {
    pair.step();
    most = std::max(most, pair.built.passage.ground_force(before + 2));
  }
  verified::above("largest force below a sleeper", "N", most,
                  {2e4, "separates: the axles pass over the ground"});
  check_balance(pair, "two axles");
}

}  // namespace
}  // namespace trackbed::model::implicit_ground_test
