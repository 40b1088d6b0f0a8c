// A wave that travels around a periodic ground.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/verified.hpp"
#include "unit/fem/compared.hpp"

namespace trackbed::fem::travelling_test {
namespace {

using par::Comm;
using std::numbers::pi;

constexpr Elastic soil{50e6, 0.3, 2000};
constexpr double length = 12, height = 1;  // m

// Angular frequency, 1/s. One row of elements on a fixed base has only the degrees of freedom of
// its top. Shear across the track, u_y = U(x) (1 + z/H): with half of the mass at the top,
//   rho H/2 d2U/dt2 = G H/3 d2U/dx2 - G/H U,  so w^2 = 2/3 c_s^2 k^2 + 2 (c_s/H)^2.
double frequency(double wave_number) {
  const double squared = soil.young / (2 * (1 + soil.poisson)) / soil.density;  // c_s^2
  return std::sqrt(squared * (2.0 / 3 * wave_number * wave_number + 2 / (height * height)));
}

// Time in which a sine of the whole length travels `circuits` times around, s, and the fraction of
// it that is a standing wave. Cosine and sine are released one after the other, a quarter period
// apart.
struct Circuits {
  double time, standing;
};
Circuits travel_around(const Comm& comm, std::int64_t elements, int circuits,
                       Integrator integrator) {
  GroundParameters p = box({length, 1, height}, {elements, 1, 1}, soil);
  p.base = Base::fixed;
  p.side_x_low = p.side_x_high = p.side_y_low = p.side_y_high = Sides::periodic;
  p.integrator = integrator;
  p.tolerance = 1e-12;
  Ground ground(comm, p, Dimension::space, 1);
  const double k = 2 * pi / length, period = 2 * pi / frequency(k);
  const auto load = [&](double cosine, double sine) {
    return traction_forces(ground, [=](const Vec3& at) -> Vec3 {
      return {0, 1e3 * (cosine * std::cos(k * at.x()) + sine * std::sin(k * at.x())), 0};
    });
  };
  const std::int64_t steps = 8 * elements;  // of a period
  const double dt = period / static_cast<double>(steps);
  ground.settle(load(1, 1));
  const auto after = load(0, 1), nothing = load(0, 0);
  double before = 0, most = 0, least = 1e300;
  std::vector<double> passed;  // s, when the wave is back at its start
  for (std::int64_t w = 1; w < (circuits + 2) * steps; ++w) {
    ground.advance(dt, w <= steps / 4 ? after : nothing);
    // Velocity along cosine and sine gives the phase of the wave; both ends are one node.
    double a = 0, b = 0;
    for (const std::int32_t n : ground.own_top()) {
      const double x = ground.top().position[static_cast<std::size_t>(n)].x();
      const double v = ground.top_state(n).velocity.y();
      if (x < length - 1e-9) a += v * std::cos(k * x), b += v * std::sin(k * x);
    }
    a = comm.sum(a), b = comm.sum(b);
    if (w > steps)
      most = std::max(most, std::hypot(a, b)), least = std::min(least, std::hypot(a, b));
    if (w > steps / 2 && before > 0 && a <= 0)
      passed.push_back((static_cast<double>(w) - a / (a - before)) * dt);
    before = a;
  }
  return {passed.at(static_cast<std::size_t>(circuits)) - passed.front(),
          (most - least) / (most + least)};
}

TEST(PeriodicGround, WaveTravelsAround) {
  const Comm comm = Comm::world();
  constexpr int circuits = 3;
  const double exact = circuits * 2 * pi / frequency(2 * pi / length);
  for (const auto& [name, integrator] :
       {std::pair{"explicit", Integrator::explicit_}, {"newmark", Integrator::newmark}}) {
    const Circuits coarse = travel_around(comm, 12, circuits, integrator);
    const Circuits fine = travel_around(comm, 24, circuits, integrator);
    const Circuits coarsest = travel_around(comm, 6, circuits, integrator);
    // Mass lumped along x, stiffness not.
    const verified::Tolerance mesh{0.006, "error of the frequency: (k h)^2 / 12 = 5.7e-3"};
    verified::near(fmt::format("time of three circuits, 24 elements, {}", name), "s", fine.time,
                   exact, mesh.of(exact));
    const verified::Tolerance order{0.15,
                                    "second order; next term (k h)^2 / 9 = 0.12 at the coarsest"};
    verified::near(fmt::format("error with 12 elements over that with 24, {}", name), "-",
                   (coarse.time - exact) / (fine.time - exact), 4, order);
    verified::near(fmt::format("error with 6 elements over that with 12, {}", name), "-",
                   (coarsest.time - exact) / (coarse.time - exact), 4, order);
    const verified::Limit early{
        8.5e-3,
        "released a quarter of the exact period apart: pi / 4 of the error of "
        "the frequency, 4.3e-3, twice"};
    verified::below(fmt::format("standing fraction of the wave, 24 elements, {}", name), "-",
                    fine.standing, early);
  }
}

}  // namespace
}  // namespace trackbed::fem::travelling_test
