// Implicit steps of yielding elements: tangents against finite differences, stresses on the yield
// surface, bitwise identity with elastic layers and through a checkpoint, ranks, agreement with the
// explicit scheme, collapse.
#include "fem/kernel/plastic_step.hpp"

#include <gtest/gtest.h>
#include <petscsys.h>

#include <cmath>
#include <random>

#include "trackbed/core/error.hpp"
#include "trackbed/fem/petsc.hpp"
#include "trackbed/io/file.hpp"
#include "unit/fem/yielding_scene.hpp"

namespace trackbed::fem::plastic_step_test {
namespace {

using par::Comm;

// All planes and corners: random stresses near the apex and far from it.
TEST(Slope, IsTheDerivativeOfTheReturn) {
  std::mt19937_64 random(5);
  const auto number = [&](double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random);
  };
  int yielded = 0;
  for (int k = 0; k < 2000; ++k) {
    const MohrCoulomb surface(
        {50e6, number(0, 0.45), 2000},
        {Yield::mohr_coulomb, 20e3, number(10, 40), number(0, 10), number(0, 20e3)});
    Vec6 trial, plastic;
    for (double& value : trial) value = number(-1e5, 1e5);
    if (k % 2 == 0) trial(3) = trial(4) = 0;  // as in a plane
    Vec6 stress = trial;
    Voigt slope;
    if (!surface.bring_back(stress, plastic, &slope)) continue;
    ++yielded;
    // A corner of the surface between both ends of a difference is not an error of the slope:
    // repeated with a shorter difference.
    double error = 1;
    for (const double h : {1.0, 0.1, 0.01}) {
      Voigt difference = Voigt::Identity();
      for (int c = 0; c < 6; ++c) {
        Vec6 high = trial, low = trial;
        high(c) += h, low(c) -= h;
        surface.bring_back(high, plastic);
        surface.bring_back(low, plastic);
        difference.col(c) = (high - low) / (2 * h);
      }
      error = std::min(error, (difference - slope).cwiseAbs().maxCoeff());
    }
    EXPECT_LT(error, 1e-4) << trial.transpose();  // rounding of 1e5 Pa over 0.01 Pa, and h^2
  }
  EXPECT_GT(yielded, 500);
}

class Step : public ::testing::TestWithParam<Dimension> {};
INSTANTIATE_TEST_SUITE_P(, Step, ::testing::Values(Dimension::plane, Dimension::space),
                         dimension_name);

// One element with random displacements: enhanced strains are active.
struct OneElement {
  explicit OneElement(Dimension dimension, double dilation)
      : parameters(make(dilation)),
        mesh(Comm::self(), parameters, dimension, 0.2),
        plasticity(mesh),
        step(mesh, plasticity),
        element(element_matrices(mesh.lattice.size, parameters.layers[0].solid, dimension,
                                 PlaneState::strain)),
        none(mesh.lattice.components(), mesh.nodes()) {}
  static GroundParameters make(double dilation) {
    GroundParameters p = box({0.3, 0.2, 0.1}, {1, 1, 1}, {50e6, 0.3, 2000});
    p.layers[0].strength = {Yield::mohr_coulomb, 20e3, 30, dilation, 10e3};
    return p;
  }
  Nodal nodal(const Eigen::VectorXd& u) const {
    Nodal values = none;
    const int parts = mesh.lattice.components();
    for (int k = 0; k < mesh.lattice.corners(); ++k)
      for (int c = 0; c < parts; ++c) values[c][mesh.corner(0, k)] = u(parts * k + c);
    return values;
  }
  // Forces on the corners at the end of a step with this motion, N.
  Eigen::VectorXd force(const Eigen::VectorXd& u) {
    step.flow(none, nodal(u));
    Nodal plastic = none;
    plasticity.act_on(plastic);
    Eigen::VectorXd found = element.stiffness * u;
    const int parts = mesh.lattice.components();
    for (int k = 0; k < mesh.lattice.corners(); ++k)
      for (int c = 0; c < parts; ++c) found(parts * k + c) += plastic[c][mesh.corner(0, k)];
    return found;
  }
  GroundParameters parameters;
  Mesh mesh;
  Plasticity plasticity;
  PlasticStep step;
  ElementMatrices element;
  Nodal none;
};

TEST_P(Step, TangentIsTheDerivativeOfTheForce) {
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal;
  using Follow = PlasticStep::Follow;
  for (const auto& [dilation, when] :
       {std::pair(0.0, Follow::at_once), std::pair(30.0, Follow::at_once),
        std::pair(0.0, Follow::next_step)}) {
    OneElement element(GetParam(), dilation);
    element.step.follow(when);
    const double size = when == Follow::at_once ? 1e-4 : 1e-3;  // m
    const Eigen::Index freedoms = element.element.stiffness.rows();
    // A first step leaves plastic strain, so that the second one does not start from zero.
    Eigen::VectorXd first(freedoms), u(freedoms);
    do {
      for (double& value : first) value = size * normal(random);
      element.force(first);
    } while (element.step.flowing() == 0);
    element.step.keep(element.none);
    int smooth = 0, tried = 0;
    for (int k = 0; k < 10; ++k) {
      for (Eigen::Index n = 0; n < freedoms; ++n) u(n) = first(n) + size * normal(random);
      element.force(u);
      if (element.step.flowing() == 0) continue;
      ++tried;
      Eigen::MatrixXd tangent = element.element.stiffness;
      element.step.tangent([&](std::size_t, const Eigen::MatrixXd& change) { tangent += change; });
      const double h = 1e-10, stiff = element.element.stiffness.cwiseAbs().maxCoeff();
      Eigen::MatrixXd difference = tangent;
      for (Eigen::Index n = 0; n < freedoms; ++n) {
        Eigen::VectorXd high = u, low = u;
        high(n) += h, low(n) -= h;
        difference.col(n) = (element.force(high) - element.force(low)) / (2 * h);
      }
      // A few trials are spoiled by a point that changes its planes: most are not.
      if ((difference - tangent).cwiseAbs().maxCoeff() < 1e-4 * stiff) ++smooth;
      if (dilation == 30) {
        EXPECT_LT((tangent - tangent.transpose()).cwiseAbs().maxCoeff(), 1e-9 * stiff);
      }
    }
    EXPECT_GE(smooth, tried - 2);
    EXPECT_GT(tried, 4);
  }
}

// The stress of the element, with enhanced strains in equilibrium, is within the yield surface at
// every point.
TEST_P(Step, StressLiesOnTheSurface) {
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  OneElement element(GetParam(), 0);
  const ElementPoints points =
      element_points(element.mesh.lattice.size, element.parameters.layers[0].solid, GetParam());
  const MohrCoulomb surface(element.parameters.layers[0].solid,
                            element.parameters.layers[0].strength);
  Eigen::VectorXd u(element.element.stiffness.rows());
  for (int k = 0; k < 20; ++k) {
    for (double& value : u) value = 2e-4 * normal(random);
    element.step.flow(element.none, element.nodal(u));
    const double before = *element.plasticity.element(0).work;
    element.step.keep(element.none);
    const int parts = points.components, count = static_cast<int>(points.relief.rows()) / parts;
    Eigen::VectorXd strain(points.relief.rows());
    for (int g = 0; g < count; ++g)
      for (int c = 0; c < parts; ++c)
        strain(parts * g + c) = element.plasticity.element(0).strain[c * count + g];
    const Eigen::VectorXd stress = points.recovery * u + points.relief * strain;
    double beyond = -1e9;
    for (int g = 0; g < count; ++g) {
      Vec6 at = Vec6::Zero();
      for (int c = 0; c < parts; ++c) at(points.voigt(c)) = stress(parts * g + c);
      beyond = std::max(beyond, surface.beyond(principal(at).value));
    }
    // Of stresses of some 1e5 Pa.
    EXPECT_LT(beyond, 1e-4);
    if (*element.plasticity.element(0).work > before) {
      EXPECT_GT(beyond, -1e-4);
    }
  }
}

// Steps with lagging enhanced strains yield as explicit ones do, step after step; the reported gain
// is the largest component of the plastic strain increment.
TEST_P(Step, LaggingStepsYieldAsExplicitOnes) {
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  OneElement lagging(GetParam(), 0), at_once(GetParam(), 0), explicit_one(GetParam(), 0);
  lagging.step.follow(PlasticStep::Follow::next_step);
  Eigen::VectorXd u(lagging.element.stiffness.rows());
  const auto width = static_cast<Eigen::Index>(lagging.plasticity.width());
  const auto strain = [&](OneElement& element) {
    return Eigen::VectorXd(
        Eigen::Map<const Eigen::VectorXd>(element.plasticity.element(0).strain, width));
  };
  for (int k = 0; k < 5; ++k) {
    for (double& value : u) value = 2e-3 * normal(random);
    const Eigen::VectorXd before = strain(lagging);
    for (OneElement* element : {&lagging, &at_once})
      element->step.flow(element->none, element->nodal(u));
    explicit_one.plasticity.flow(explicit_one.none, explicit_one.nodal(u));
    ASSERT_EQ(lagging.step.flowing(), 1u);
    EXPECT_EQ(lagging.step.unsolved(), 0u);
    const double gain = (strain(lagging) - before).cwiseAbs().maxCoeff();
    EXPECT_NEAR(lagging.step.largest_increment(), gain, 1e-9 * gain);
    EXPECT_LT((strain(lagging) - strain(explicit_one)).norm(), 1e-9 * gain);
    EXPECT_GT((strain(lagging) - strain(at_once)).norm(), 1e-2 * gain);
    for (OneElement* element : {&lagging, &at_once}) element->step.keep(element->none);
  }
}

GroundParameters scene(Integrator integrator = Integrator::newmark) {
  GroundParameters p = yielding_scene();
  p.integrator = integrator;
  p.tolerance = 1e-10;
  return p;
}

void go(Ground& ground, int from, int to, double dt = 5e-4) {
  for (int w = from; w < to; ++w) ground.advance(dt, load_of(ground.top(), w));
}

// Forces and inertia weighted between begin and end: restarts of every integrator are identical.
TEST_P(Step, CheckpointIsBitwiseIdentical) {
  const Comm world = Comm::world();
  const std::string path = "plastic_step_on_" + std::to_string(world.size()) +
                           (GetParam() == Dimension::plane ? "_plane.h5" : "_space.h5");
  for (const Integrator integrator : {Integrator::newmark, Integrator::generalized_alpha}) {
    const GroundParameters p = scene(integrator);
    Ground ground(world, p, GetParam(), 1.0), resumed(world, p, GetParam(), 1.0);
    ground.settle(settled(ground.top()));
    go(ground, 0, 5);
    {
      io::File file(world, path, io::Mode::create);
      ground.save(file, "ground");
    }
    go(ground, 5, 10);
    {
      const io::File file(world, path, io::Mode::read);
      resumed.load(file, "ground");
    }
    go(resumed, 5, 10);
    EXPECT_EQ(bits(world, ground), bits(world, resumed));
    EXPECT_GT(ground.totals().plastic, 0.01 * ground.totals().elastic);
    EXPECT_GT(ground.totals().newton_mean, 1);
  }
}

TEST_P(Step, RanksAgreeToTheTolerance) {
  const Comm world = Comm::world(), self = Comm::self();
  Ground spread(world, scene(), GetParam(), 1.0), alone(self, scene(), GetParam(), 1.0);
  for (Ground* ground : {&spread, &alone}) {
    ground->settle(settled(ground->top()));
    go(*ground, 0, 10);
  }
  double difference = 0, size = 0;
  for (const std::int32_t n : spread.own_top()) {
    const Vec3 u = alone.top_state(n).displacement;
    size = std::max(size, u.norm());
    difference = std::max(difference, (spread.top_state(n).displacement - u).norm());
  }
  // Residuals of 1e-10 times the condition of a step, some hundred, in each of ten steps.
  EXPECT_LT(world.max(difference), 1e-7 * world.max(size));
}

TEST_P(Step, StrongLayersAreBitwiseIdenticalToElasticOnes) {
  const Comm self = Comm::self();
  GroundParameters strong = scene(), elastic = scene();
  for (Strength* s : {&strong.layers[0].strength, &strong.blocks[0].strength})
    s->cohesion = s->tensile_strength = 1e9;
  elastic.layers[0].strength.yield = elastic.blocks[0].strength.yield = Yield::none;
  Ground a(self, strong, GetParam(), 1.0), b(self, elastic, GetParam(), 1.0);
  go(a, 0, 8);
  go(b, 0, 8);
  EXPECT_EQ(bits(self, a), bits(self, b));
  EXPECT_EQ(a.totals().plastic, 0);
}

// All schemes with decreasing steps converge to one motion, with first order as the return mapping.
// A scheme that weights forces must also weight those of plastic strain, or would be off by its
// weight.
TEST_P(Step, AgreesWithTheExplicitScheme) {
  const Comm self = Comm::self();
  const auto run = [&](Integrator integrator, double dt) {
    GroundParameters p = scene(integrator);
    p.safety = 0.05;
    p.alpha = -0.3;
    p.rho_inf = 0.3;
    Ground ground(self, p, GetParam(), 1.0);
    const auto static_load = settled(ground.top()), push = load_of(ground.top(), 5);
    ground.settle(static_load);
    const int windows = static_cast<int>(std::lround(4e-3 / dt));
    for (int w = 0; w < windows; ++w) {
      // Rises and falls: loading and unloading. Linear within a window for one scheme, constant at
      // its mean for the other.
      const double t = (integrator == Integrator::explicit_ ? w + 0.5 : w + 1) * dt / 4e-3;
      auto load = static_load;
      for (std::size_t n = 0; n < load.size(); ++n)
        load[n] += std::sin(M_PI * t) * (push[n] - static_load[n]);
      ground.advance(dt, load);
    }
    EXPECT_GT(ground.totals().plastic, 0);
    std::vector<double> u;
    for (const std::int32_t n : ground.own_top()) u.push_back(ground.top_state(n).displacement.z());
    return u;
  };
  const auto apart = [](const std::vector<double>& a, const std::vector<double>& b) {
    double difference = 0, size = 0;
    for (std::size_t n = 0; n < a.size(); ++n) {
      difference = std::max(difference, std::abs(a[n] - b[n]));
      size = std::max(size, std::abs(a[n]));
    }
    return difference / size;
  };
  const auto exact = run(Integrator::explicit_, 1e-4);
  for (const Integrator scheme :
       {Integrator::newmark, Integrator::hht, Integrator::generalized_alpha}) {
    const double coarse = apart(exact, run(scheme, 1e-3)), fine = apart(exact, run(scheme, 1e-4));
    EXPECT_LT(fine, 0.01) << static_cast<int>(scheme);
    EXPECT_LT(fine, 0.5 * coarse) << static_cast<int>(scheme);
  }
}

// Newton's method adapts the tolerance of its solves; a tolerance given by the user has priority.
TEST(Tangent, TakesTheToleranceGiven) {
  constexpr const char* option = "-ground_tangent_ksp_rtol";
  const auto iterations = [&](const char* tolerance) {
    Petsc::ensure();
    if (tolerance != nullptr) PetscOptionsSetValue(nullptr, option, tolerance);
    const Comm self = Comm::self();
    Ground ground(self, scene(), Dimension::plane, 1.0);
    ground.settle(settled(ground.top()));
    go(ground, 0, 5);
    PetscOptionsClearValue(nullptr, option);
    return ground.totals().newton_mean;
  };
  EXPECT_GT(iterations("0.5"), 1.5 * iterations(nullptr));
}

// Half of a strip under twice its bearing capacity, applied suddenly and for so long that inertia
// is negligible: no convergence, and the run reports it.
TEST(Collapse, EndsWithAnError) {
  GroundParameters p = box({2.5, 1, 1.25}, {10, 1, 5}, {50e6, 0.3, 2000});
  p.plane = PlaneState::strain;
  p.base = Base::fixed;
  p.integrator = Integrator::newmark;
  p.layers[0].strength = {Yield::mohr_coulomb, 50e3, 0, 0, 50e6};
  Ground ground(Comm::world(), p, Dimension::plane, 1.0);
  std::vector<Vec3> force(ground.top().nodes(), Vec3::Zero());
  for (std::size_t n = 0; n < force.size(); ++n)
    if (ground.top().position[n].x() < 0.6) force[n].z() = -0.5 * 0.25 * 10 * 50e3;
  try {
    ground.advance(1e3, force);
    FAIL() << "a load of twice the bearing capacity converges";
  } catch (const RunError& error) {
    EXPECT_NE(std::string(error.what()).find("an implicit step of the ground did not converge"),
              std::string::npos)
        << error.what();
  }
}

// With less dilation than friction a step may lag. A collapse would also balance as a lagging step,
// by plastic strains far beyond the limit of a step: that of 400 kPa does, for any number of steps,
// without a limit.
TEST(Collapse, IsNotAcceptedAsALaggingStep) {
  for (const double pushed : {200e3, 400e3}) {  // Pa
    GroundParameters p = box({2.5, 1, 1.25}, {10, 1, 5}, {50e6, 0.3, 2000});
    p.plane = PlaneState::strain;
    p.base = Base::fixed;
    p.integrator = Integrator::newmark;
    p.layers[0].strength = {Yield::mohr_coulomb, 10e3, 32, 0, 5e3};
    Ground ground(Comm::world(), p, Dimension::plane, 1.0);
    ground.settle(pressure(ground, 0));
    std::vector<Vec3> force = pressure(ground, pushed);
    for (std::size_t n = 0; n < force.size(); ++n)
      if (ground.top().position[n].x() > 0.6) force[n] = Vec3::Zero();
    const bool carried = pushed < 300e3;
    if (carried) {
      EXPECT_NO_THROW(ground.advance(1e3, force));
    } else {
      EXPECT_THROW(ground.advance(1e3, force), RunError);
    }
    // Both are tried as lagging steps, after 20 cycling iterations.
    EXPECT_EQ(ground.totals().lagging_steps, carried ? 1 : 0);
    EXPECT_GT(ground.totals().newton_most, 20);
  }
}

// Without weight a slab that is launched upwards separates from the rest of its column.
TEST(Collapse, StrainsAboveOneAreAnError) {
  GroundParameters p = box({1, 1, 4}, {2, 1, 8}, {20e6, 0.2, 2000});
  p.plane = PlaneState::strain;
  p.base = Base::fixed;
  p.integrator = Integrator::newmark;
  p.layers[0].strength = {Yield::mohr_coulomb, 100, 30, 0, 0};
  Ground ground(Comm::world(), p, Dimension::plane, 1.0);
  ground.settle(pressure(ground, 0));
  const std::vector<Vec3> pull = pressure(ground, -200e3);
  try {
    for (int w = 0; w < 1000; ++w) ground.advance(1e-3, pull);
    FAIL() << "a column in tension for a second does not fail";
  } catch (const RunError& error) {
    EXPECT_NE(std::string(error.what()).find("the ground fails: plastic strains reach 1"),
              std::string::npos)
        << error.what();
  }
}

// A deep ground that yields in static equilibrium: the residual is rounding of its stress.
TEST(Unloaded, StaysAtRest) {
  for (const double change : {0.0, 1e-12, 1e-6, 1e-3}) {
    GroundParameters p = box({10, 5, 40}, {4, 2, 10}, {50e6, 0.1, 2000});
    p.base = Base::fixed;
    p.integrator = Integrator::hht;
    p.layers[0].strength = {Yield::mohr_coulomb, 1e3, 20, 0, 1e3};
    Ground ground(Comm::world(), p, Dimension::space, 1.0);
    ground.settle(pressure(ground, 20e3));
    const std::vector<Vec3> load = pressure(ground, 20e3 + change);  // Pa
    for (int w = 0; w < 10; ++w) EXPECT_NO_THROW(ground.advance(5e-4, load)) << change;
    for (const auto n : ground.own_top())
      EXPECT_LT(std::abs(ground.top_state(n).displacement.z()), 1e-9);  // m
  }
}

// A load far below the strength causes no yielding for any step length: accelerations change their
// sign from step to step, and extrapolation from them is beyond the strength.
TEST(LongSteps, DoNotYieldFarBelowTheStrength) {
  for (const Integrator integrator :
       {Integrator::newmark, Integrator::hht, Integrator::generalized_alpha})
    for (const double dt : {0.1, 10.0}) {  // s
      GroundParameters p = box({2, 1, 2}, {8, 4, 8}, {50e6, 0.3, 2000});
      p.base = Base::fixed;
      p.integrator = integrator;
      p.layers[0].strength = {Yield::mohr_coulomb, 10e3, 20, 0, 5e3};
      Ground ground(Comm::world(), p, Dimension::space, 1.0);
      std::vector<Vec3> load = pressure(ground, 0);
      ground.settle(load);
      const std::vector<Vec3> none = load, all = pressure(ground, 5e3);  // a sixth of the strength
      for (std::size_t n = 0; n < load.size(); ++n)
        if (ground.top().position[n].x() < 0.6) load[n] = all[n];
      for (int w = 0; w < 10; ++w) ground.advance(dt, w < 5 ? load : none);
      EXPECT_EQ(ground.totals().plastic, 0) << dt;
      EXPECT_EQ(ground.totals().newton_most, 1) << dt;
    }
}

// By explicit steps this ground hardly yields. The work of the load is some 10 J.
TEST(LongSteps, DissipateNoWork) {
  GroundParameters p = box({4, 1, 4}, {16, 1, 16}, {50e6, 0.3, 2000});
  p.plane = PlaneState::strain;
  p.base = Base::fixed;
  p.integrator = Integrator::newmark;
  p.layers[0].strength = {Yield::mohr_coulomb, 20e3, 30, 0, 10e3};
  Ground ground(Comm::world(), p, Dimension::plane, 1.0);
  ground.settle(pressure(ground, 0));
  std::vector<Vec3> load = pressure(ground, 20e3);
  for (std::size_t n = 0; n < load.size(); ++n)
    if (ground.top().position[n].x() > 1) load[n] = Vec3::Zero();
  for (int w = 0; w < 20; ++w) {
    ground.advance(0.2, load);
    EXPECT_LT(std::abs(ground.totals().plastic), 1.0) << "step " << w;  // J
  }
}

}  // namespace
}  // namespace trackbed::fem::plastic_step_test
