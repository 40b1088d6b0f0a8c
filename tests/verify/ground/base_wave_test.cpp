// A wave from below between free-field sides (reference case "Free field"): a vertically
// propagating shear wave doubles at the top, arrives in time, and is not disturbed by the sides; a
// dead load causes no creep and does not change it; a block in the ground moves as in a much wider
// ground.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "support/verified.hpp"
#include "unit/fem/ground_scene.hpp"
#include "unit/fem/wave.hpp"

namespace trackbed::fem::base_wave_test {
namespace {

using par::Comm;

constexpr Elastic rock{3e9, 0.3, 2100};
constexpr double height = 140, standard = 9.81;  // m, m/s^2
constexpr Ricker wave{10, 0.15};                 // Hz, s

GroundParameters hill(const Comm& comm, double centre) {
  GroundParameters p = box({60, 20, height}, {12, 4, 140}, rock);
  p.plane = PlaneState::strain;
  p.sides = Sides::free_field;
  p.base_motion = wave_table(comm, fmt::format("ricker_{:g}", centre), {wave.frequency, centre},
                             standard, 0, 2.5e-4);
  return p;
}

class ShearWave : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, ShearWave, ::testing::Values(Dimension::plane, Dimension::space),
                         dimension_name);

TEST_P(ShearWave, FromBelowDoublesAtTheTop) {
  const Comm comm = Comm::world();
  Ground ground(comm, hill(comm, wave.centre), GetParam(), 1.0);
  const std::vector<Vec3> none(ground.top().nodes(), Vec3::Zero());
  ground.settle(none);
  constexpr double dt = 1e-3;
  std::vector<double> shown;  // acceleration of the top, m/s^2
  double apart = 0;
  for (int w = 0; w < 450; ++w) {
    ground.advance(dt, none);
    double low = 1e300, high = -1e300;
    for (const auto n : ground.own_top()) {
      const double a = ground.top_state(n).acceleration.x();
      low = std::min(low, a), high = std::max(high, a);
    }
    shown.push_back(comm.max(high));
    apart = std::max(apart, shown.back() + comm.max(-low));
  }
  // Peak of the parabola through the largest value and its neighbours.
  const auto top =
      static_cast<std::size_t>(std::max_element(shown.begin(), shown.end()) - shown.begin());
  const double before = shown[top - 1], at = shown[top], after = shown[top + 1];
  const double shift = 0.5 * (before - after) / (before - 2 * at + after);
  const double peak = at - 0.25 * (before - after) * shift;
  const double when = (static_cast<double>(top) + 1 + shift) * dt - wave.centre;
  // Elements of 1 m, omega h / c = 0.085 at 10 Hz. In the delay of a peak each frequency of the
  // wave counts with its square, which makes 2.5 times that of 10 Hz.
  const verified::Tolerance ends{2e-3, "base and top, (omega h / c)^2 / 8 = 9e-4 at 10 Hz, twice"};
  verified::near("peak acceleration of the top", "m/s^2", peak, 2 * standard,
                 ends.of(2 * standard));
  verified::near("time after the peak at the base", "s", when, 188.87e-3,
                 {0.3e-3, "speed: 2.5 (omega h / c)^2 / 24 of 0.19 s, 0.14 ms, twice"});
  verified::below("largest difference between any two top nodes over the peak", "-", apart / peak,
                  {2e-11, "rounding: 1e-16 (2 c_p / h)^2 u is 2e-13 of it, in 1000 steps"});
}

// 10 s under a dead load, then the wave: the load causes no creep and does not change the wave.
TEST(FreeField, DeadLoadNeitherCreepsNorChangesTheWave) {
  const Comm comm = Comm::world();
  Ground loaded(comm, hill(comm, 10.15), Dimension::plane, 1.0);
  Ground bare(comm, hill(comm, wave.centre), Dimension::plane, 1.0);
  auto load = pressure(loaded, 50e3);
  for (std::size_t n = 0; n < load.size() / 3; ++n) load[n] *= 3;  // uneven
  const std::vector<Vec3> none(bare.top().nodes(), Vec3::Zero());
  loaded.settle(load);
  bare.settle(none);
  double creep = 0, difference = 0, largest = 0;
  for (int w = 0; w < 100; ++w) loaded.advance(0.1, load);
  for (const auto n : loaded.own_top())
    creep = std::max(creep, loaded.top_state(n).displacement.norm());
  for (int w = 0; w < 400; ++w) {
    loaded.advance(1e-3, load);
    bare.advance(1e-3, none);
    for (const auto n : loaded.own_top()) {
      const Vec3 u = bare.top_state(n).displacement;
      difference = std::max(difference, (loaded.top_state(n).displacement - u).norm());
      largest = std::max(largest, u.norm());
    }
  }
  verified::below("displacement after 10 s under a dead load", "m", comm.max(creep),
                  {1e-15, "exact: only changes of the load act on the ground"});
  verified::below("difference of the wave with and without the load over its size", "-",
                  comm.max(difference) / comm.max(largest),
                  {1e-10, "10 s later: rounding of times, 2e-15 s in 2e4 steps, times omega"});
}

// Displacement along x of the middle of the top, window after window, of a ground of soil with a
// block of concrete in it, `elements` wide.
std::vector<double> middle_of_block(const Comm& comm, std::int64_t elements, Sides sides) {
  GroundParameters p = box({1.0 * static_cast<double>(elements), 1, 20}, {elements, 1, 20}, {});
  p.x = {-0.5 * static_cast<double>(elements), 0.5 * static_cast<double>(elements)};
  p.layers[0].solid = {100e6, 0.3, 1900};
  p.blocks = {{"block", true, {-4, 0, 4, 0, 4, -6, -4, -6}, {30e9, 0.2, 2400}}};
  p.plane = PlaneState::strain;
  p.sides = sides;
  p.base_motion = wave_table(comm, "block", {6, 0.25}, 1.0, 0, 1e-3);
  Ground ground(comm, p, Dimension::plane, 1.0);
  const std::vector<Vec3> none(ground.top().nodes(), Vec3::Zero());
  std::vector<double> shown;
  for (int w = 0; w < 220; ++w) {
    ground.advance(4e-3, none);
    double mine = -1e300;
    for (const auto n : ground.own_top())
      if (n == elements / 2) mine = ground.top_state(n).displacement.x();
    shown.push_back(comm.max(mine));
  }
  return shown;
}

TEST(FreeField, BlockMovesAsInAWideGround) {
  const Comm comm = Comm::world();
  // At 200 m waves scattered by the block do not return within 0.9 s at 240 m/s (P).
  const auto exact = middle_of_block(comm, 440, Sides::free_field);
  const auto error = [&](Sides sides) {
    const auto shown = middle_of_block(comm, 40, sides);
    double largest = 0, difference = 0;
    for (std::size_t w = 0; w < exact.size(); ++w) {
      largest = std::max(largest, std::abs(exact[w]));
      difference = std::max(difference, std::abs(shown[w] - exact[w]));
    }
    return difference / largest;
  };
  const double free_field = error(Sides::free_field), viscous = error(Sides::viscous);
  verified::below("largest error of the displacement over its size, sides 16 m from the block", "-",
                  free_field,
                  {0.05, "partly reflected are only waves scattered at an angle, a few percent"});
  verified::above("that with viscous sides, which absorb the wave", "-", viscous,
                  {3 * free_field, "separates: sides that absorb the wave itself"});
}

}  // namespace
}  // namespace trackbed::fem::base_wave_test
