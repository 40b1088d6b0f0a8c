// Yielding tetrahedra: forces, bitwise identity on any number of ranks, restart, implicit steps.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "fem/kernel/plastic_step.hpp"
#include "trackbed/core/error.hpp"
#include "trackbed/io/file.hpp"
#include "unit/fem/embankment_scene.hpp"
#include "unit/fem/pushed_top.hpp"

namespace trackbed::fem::plastic_tetrahedra_test {
namespace {

using par::Comm;

// Fill and soil yield under the load on the crest; the capping layer does not.
GroundParameters soft() {
  GroundParameters p = embankment();
  p.sections = {{.x = 0, .crest = 3}, {.x = 6, .crest = 4, .slope = 1.6}};
  p.layers[1].strength = {Yield::mohr_coulomb, 12e3, 20, 5, 5e3};
  p.layers[2].strength = {Yield::mohr_coulomb, 15e3, 10, 0, 5e3};
  p.rayleigh_mass = 20;
  return p;
}

// N, on the middle of the crest.
std::vector<Vec3> load(const Surface& top, double pressure) {
  std::vector<Vec3> force(top.nodes(), Vec3::Zero());
  for (const auto& t : top.triangles) {
    const auto at = [&](std::size_t k) { return top.position[static_cast<std::size_t>(t[k])]; };
    const Vec3 centre = (at(0) + at(1) + at(2)) / 3;
    if (std::abs(centre.y()) > 1.3) continue;
    const double third = 0.5 * (at(1) - at(0)).cross(at(2) - at(0)).z() / 3;
    for (const std::int32_t n : t) force[static_cast<std::size_t>(n)].z() -= pressure * third;
  }
  return force;
}

// The force of plastic strain is that of the matrices of the points, the tangent its derivative.
TEST(PlasticTetrahedra, TangentIsTheDerivativeOfTheForce) {
  GroundParameters p = soft();
  p.layers[1].strength.dilation_angle = 0;
  const Mesh mesh(Comm::self(), p, Dimension::space, 1);
  const Stiffness stiffness(mesh, {});
  Plasticity plasticity(mesh, &stiffness.tetrahedra());
  PlasticStep step(mesh, plasticity);
  Nodal rest(3, mesh.nodes()), u(3, mesh.nodes()), way(3, mesh.nodes());
  for (std::size_t n = 0; n < mesh.nodes(); ++n) {
    const Vec3 x = mesh.position(static_cast<std::int32_t>(n));
    u[2][n] = 2e-3 * x.z() + 4e-4 * std::sin(3 * x.y()) * x.z();
    u[1][n] = 3e-4 * x.y() * x.z();
    for (int c = 0; c < 3; ++c) way[c][n] = std::sin(1.7 * static_cast<double>(n) + c);
  }
  const auto force_at = [&](double length) {
    Nodal moved = u, force(3, mesh.nodes());
    for (int c = 0; c < 3; ++c)
      for (std::size_t n = 0; n < mesh.nodes(); ++n) moved[c][n] += length * way[c][n];
    step.flow(rest, moved);
    plasticity.act_on(force);
    return force;
  };
  const double length = 1e-9;
  const Nodal after = force_at(length), before = force_at(-length);
  force_at(0);
  EXPECT_GT(step.flowing(), 50u);
  EXPECT_EQ(step.unsolved(), 0u);
  Nodal found(3, mesh.nodes());
  step.tangent([&](std::size_t element, const Eigen::MatrixXd& k) {
    Eigen::VectorXd mine(30);
    for (int f = 0; f < 30; ++f) mine[f] = way[f % 3][mesh.corner(element, f / 3)];
    const Eigen::VectorXd force = k * mine;
    for (int f = 0; f < 30; ++f) found[f % 3][mesh.corner(element, f / 3)] += force[f];
  });
  double off = 0, size = 0;
  for (int c = 0; c < 3; ++c)
    for (std::size_t n = 0; n < mesh.nodes(); ++n) {
      const double slope = (after[c][n] - before[c][n]) / (2 * length);
      off = std::max(off, std::abs(found[c][n] - slope));
      size = std::max(size, std::abs(slope));
    }
  EXPECT_LT(off, 1e-4 * size);
}

// Work of the load = kinetic + elastic + dissipated energy, without other dissipation: to the order
// of the step. With weight, from an elastic static state; compressed, and in tension until elements
// open, whose weight is carried by their inertia.
TEST(PlasticTetrahedra, EnergyIsBalanced) {
  const auto error = [](double safety, double pressure) {
    GroundParameters p = soft();
    p.rayleigh_mass = 0;
    p.safety = safety;
    Ground ground(Comm::self(), p, Dimension::space, 1);
    const std::vector<Vec3> static_load = load(ground.top(), 0),
                            push = load(ground.top(), pressure);
    ground.settle(static_load);
    double work = 0;
    EXPECT_EQ(ground.totals().plastic, 0);
    for (int w = 0; w < 150; ++w) {
      const std::vector<Vec3>& force = w < 80 ? push : static_load;
      ground.advance(1e-3, force);
      for (std::size_t n = 0; n < force.size(); ++n)
        work += (force[n] - static_load[n]).dot(ground.top().motion[n]);
    }
    const GroundTotals end = ground.totals();
    EXPECT_GT(end.plastic, 0.15 * work);
    return std::abs(end.kinetic + end.elastic + end.plastic - work) / work;
  };
  // Order one, as the return mapping: a fifth of the step, less than half of the error, and more
  // than a 25th, which would be order two.
  // Where elements open, forces start suddenly: a larger error in a step.
  for (const auto& [pressure, most] : {std::pair{60e3, 3e-4}, {-30e3, 1e-3}}) {
    const double coarse = error(0.5, pressure), fine = error(0.1, pressure);
    EXPECT_LT(coarse, most);
    EXPECT_LT(fine, 0.5 * coarse);
    EXPECT_GT(fine, coarse / 25);
  }
}

// `kilopascals` more in each window, until elements yield.
void check_bits(double kilopascals) {
  const GroundParameters p = soft();
  const Comm world = Comm::world();
  Ground alone(Comm::self(), p, Dimension::space, 1), shared(world, p, Dimension::space, 1);
  Ground second(world, p, Dimension::space, 1);
  const double dt = 2.5 * shared.stable_step();
  // Loads of the same top, as its position depends on the last window.
  const std::vector<Vec3> one_kilopascal = load(shared.top(), 1e3);
  const auto force = [&](int w) {
    std::vector<Vec3> all = one_kilopascal;
    for (Vec3& one : all) one *= kilopascals * w;
    return all;
  };
  for (Ground* ground : {&alone, &shared}) {
    ground->settle(load(ground->top(), 0));
    for (int w = 1; w < 40; ++w) ground->advance(dt, force(w));
  }
  EXPECT_GT(shared.totals().plastic, 1);
  const std::string path = fmt::format("plastic_tetrahedra_on_{}.h5", world.size());
  {
    io::File file(world, path, io::Mode::create);
    shared.save(file, "ground");
  }
  {
    const io::File file(world, path, io::Mode::read);
    second.load(file, "ground");
  }
  for (Ground* ground : {&alone, &shared, &second})
    for (int w = 40; w < 50; ++w) ground->advance(dt, force(w));
  const std::vector<double> one = shape_of(Comm::self(), alone);
  EXPECT_EQ(one, shape_of(world, shared));
  EXPECT_EQ(one, shape_of(world, second));
  EXPECT_EQ(shared.totals().plastic, second.totals().plastic);
  EXPECT_EQ(shared.trouble(), "");
}

TEST(PlasticTetrahedra, IsBitwiseIdenticalOnRanksAndThroughACheckpoint) { check_bits(4); }
TEST(PlasticTetrahedra, IsBitwiseIdenticalInTension) { check_bits(-1.5); }

// A load applied suddenly and kept, with much damping: both kinds of steps have the same end state.
TEST(PlasticTetrahedra, ImplicitStepsAgreeWithExplicitOnes) {
  GroundParameters p = soft();
  p.rayleigh_mass = 60;
  const auto settles = [&](double window) {
    Ground ground(Comm::world(), p, Dimension::space, 1);
    ground.settle(load(ground.top(), 0));
    const std::vector<Vec3> force = load(ground.top(), 40e3);
    for (int w = 0; w * window < 0.6; ++w) ground.advance(window, force);
    EXPECT_EQ(ground.trouble(), "");
    EXPECT_GT(ground.totals().plastic, 1);
    const std::vector<double> shape = shape_of(Comm::world(), ground);
    return -*std::min_element(shape.begin(), shape.end());
  };
  const double exact = settles(0.01);
  p.integrator = Integrator::newmark;
  EXPECT_NEAR(settles(2e-3), exact, 0.01 * exact);
}

}  // namespace
}  // namespace trackbed::fem::plastic_tetrahedra_test
