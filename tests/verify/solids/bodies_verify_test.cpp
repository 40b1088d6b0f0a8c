// Solid sleepers against beams and against rigid ones.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "fem/bodies/bodies_system.hpp"
#include "support/verified.hpp"
#include "trackbed/track/sleepers.hpp"

namespace trackbed::fem::bodies_verify_test {
namespace {

const Elastic concrete{.young = 37e9, .poisson = 0.2, .density = 2548};
constexpr double width = 0.29, height = 0.22, length = 2.6;  // m

// The deck's default elements, about 0.1 m, `finer` times as many in each direction.
Body sleeper(int finer = 1, const Elastic& solid = concrete) {
  return {.name = "sleeper",
          .low = {-width / 2, -length / 2, 0},
          .high = {width / 2, length / 2, height},
          .elements = {3 * finer, 26 * finer, 2 * finer},
          .solid = solid};
}

// First symmetric bending mode of a free Timoshenko beam, rad/s. With w = A cos b y + B cosh a y
// about the middle, b and a from its differential equation; moment and shear force vanish at y =
// l/2.
double timoshenko_mode() {
  const double area = width * height, inertia = width * height * height * height / 12;
  const double nu = concrete.poisson, shear_factor = 10 * (1 + nu) / (12 + 11 * nu);  // Cowper 1966
  const double shear = concrete.young / (2 * (1 + nu));
  const auto gap = [&](double omega) {
    const double square = concrete.density * omega * omega;
    const double p = square / concrete.young, q = square / (shear_factor * shear);
    const double root =
        std::sqrt((p - q) * (p - q) + 4 * square * area / (concrete.young * inertia));
    const double b = std::sqrt((p + q + root) / 2), a = std::sqrt((-p - q + root) / 2);
    const double x = b * length / 2, y = a * length / 2;
    return (q - b * b) * std::cos(x) * std::sinh(y) / a -
           (q + a * a) * std::cosh(y) * std::sin(x) / b;
  };
  const double euler = std::pow(4.730041 / length, 2) *
                       std::sqrt(concrete.young * inertia / (concrete.density * area));
  double low = 0.7 * euler, high = euler;
  for (int k = 0; k < 60; ++k) {
    const double middle = (low + high) / 2;
    ((gap(low) > 0) == (gap(middle) > 0) ? low : high) = middle;
  }
  return (low + high) / 2;
}

// By inverse iteration with a shift near the frequency, rad/s.
double first_mode(const Body& body, double nearby) {
  const std::vector<BodyMesh> meshes = {BodyMesh(body, 0)};
  BodiesParameters parameters;
  parameters.bodies = {body};
  const BodiesSystem system(meshes, parameters);
  const Eigen::SimplicialLDLT<BodiesSystem::Sparse> factor(system.stiffness() -
                                                           nearby * nearby * system.mass());
  BodiesSystem::Vector mode = BodiesSystem::Vector::Zero(system.mass().rows());
  for (std::int32_t n = 0; n < meshes[0].nodes(); ++n)
    system.put(n, {0, 0, std::cos(2 * std::numbers::pi * meshes[0].position(n).y() / length)},
               mode);
  for (int k = 0; k < 20; ++k) {
    mode = factor.solve(system.mass() * mode);
    mode /= std::sqrt(mode.dot(system.mass() * mode));
  }
  return std::sqrt(mode.dot(system.stiffness() * mode));
}

TEST(SolidSleeper, HasTheBendingModeOfAFreeBeam) {
  const double beam = timoshenko_mode();
  const double coarse = first_mode(sleeper(), 0.99 * beam),
               fine = first_mode(sleeper(2), 0.99 * beam);
  const double hertz = 1 / (2 * std::numbers::pi);
  const verified::Tolerance theory{5e-3, "plane sections against a solid: (h / l)^2 = 7e-3"};
  const verified::Tolerance mesh{5e-3, "mesh: (k h)^2 / 12 = 2.8e-3, k l = 4.73, almost twice"};
  verified::near("first free bending mode, elements of 0.1 m", "Hz", coarse * hertz, fine * hertz,
                 mesh.of(fine * hertz));
  verified::near("first free bending mode, elements of 0.05 m, against Timoshenko", "Hz",
                 fine * hertz, beam * hertz, theory.of(beam * hertz));
}

// Static, on springs below its whole lower face, with a load at the middle of its upper one.
struct Bedded {
  double deflection, bending_stress;  // m below the load; Pa at the lower face beside it
};
constexpr double beside =
    0.35;  // m, at the middle of an element; closer to the load beam theory does not apply
Bedded bedded(const Body& body, double modulus, double load) {
  const std::vector<BodyMesh> meshes = {BodyMesh(body, 0)};
  BodiesParameters parameters;
  parameters.bodies = {body};
  const BodiesSystem system(meshes, parameters);
  const BodyMesh& mesh = meshes[0];
  // Vertical springs, and weak ones along x and y, which prevent rigid motion.
  std::vector<Eigen::Triplet<double>> springs;
  constexpr int parts = 2;  // Gauss points of an element's edge
  const double gauss = 1 / std::sqrt(3.0), area = mesh.lattice.size.x() * mesh.lattice.size.y() / 4;
  for (std::int64_t i = 0; i < parts * body.elements[0]; ++i)
    for (std::int64_t j = 0; j < parts * body.elements[1]; ++j) {
      const auto place = [&](std::int64_t k, double low, double size) {
        return low + size * (static_cast<double>(k / 2) + 0.5 + (k % 2 == 0 ? -0.5 : 0.5) * gauss);
      };
      const NodeWeights at = mesh.at(Side::lower, place(i, body.low.x(), mesh.lattice.size.x()),
                                     place(j, body.low.y(), mesh.lattice.size.y()));
      for (const NodeWeight& a : at)
        for (const NodeWeight& b : at)
          for (int c = 0; c < 3; ++c)
            springs.emplace_back(system.unknown(a.node, c), system.unknown(b.node, c),
                                 (c == 2 ? 1 : 1e-3) * modulus * area * a.weight * b.weight);
    }
  BodiesSystem::Sparse all(system.mass().rows(), system.mass().rows());
  all.setFromTriplets(springs.begin(), springs.end());
  all += system.stiffness();
  // A line load across the sleeper, as in beam theory.
  BodiesSystem::Vector force = BodiesSystem::Vector::Zero(all.rows());
  for (int k = 0; k < 30; ++k)
    for (const NodeWeight& one : mesh.at(Side::upper, body.low.x() + (k + 0.5) / 30 * width, 0))
      system.add(one.node, {0, 0, -load / 30 * one.weight}, force);
  const BodiesSystem::Vector u = Eigen::SimplicialLDLT<BodiesSystem::Sparse>(all).solve(force);
  Bedded found{};
  for (const NodeWeight& one : mesh.at(Side::lower, 0, 0))
    found.deflection -= one.weight * system.of(u, one.node).z();
  const BodyMesh::Place below = mesh.around({0, beside, 0}).back();
  Eigen::Matrix<double, 24, 1> corners;
  for (int k = 0; k < 8; ++k)
    corners.segment<3>(3 * k) =
        system.of(u, mesh.corners(below.element)[static_cast<std::size_t>(k)]);
  found.bending_stress = (mesh.hexahedron.stress(below.xi) * corners)[1];
  return found;
}

// Hetenyi 1946, Beams on Elastic Foundation: EI w'''' + k w = 0 has solutions cosh cos, sinh sin,
// cosh sin and sinh cos of b y, b = (k/4EI)^(1/4), each a combination of them when differentiated.
// Here with free ends and half the load on either side of the middle: deflection at the middle, m,
// and bending moment at `beside`, N m.
std::array<double, 2> beam_on_bed(double k, double bending_stiffness, double load) {
  const double b = std::pow(k / (4 * bending_stiffness), 0.25);
  Eigen::Matrix4d slope;  // derivatives of the four functions
  slope << 0, 0, -1, 1, 0, 0, 1, 1, 1, 1, 0, 0, 1, -1, 0, 0;
  slope *= b;
  const auto derived = [&](double y, int times) {
    const double c = std::cosh(b * y), s = std::sinh(b * y);
    Eigen::Vector4d value(c * std::cos(b * y), s * std::sin(b * y), c * std::sin(b * y),
                          s * std::cos(b * y));
    for (int k = 0; k < times; ++k) value = (slope * value).eval();
    return value;
  };
  Eigen::Matrix4d conditions;
  conditions.row(0) = derived(0, 1);
  conditions.row(1) = derived(0, 3);
  conditions.row(2) = derived(length / 2, 2);
  conditions.row(3) = derived(length / 2, 3);
  const Eigen::Vector4d right(0, load / (2 * bending_stiffness), 0, 0);
  const Eigen::Vector4d factors = conditions.fullPivLu().solve(right);
  return {factors.dot(derived(0, 0)), -bending_stiffness * factors.dot(derived(beside, 2))};
}

TEST(SolidSleeper, BendsOnABedLikeABeam) {
  constexpr double modulus = 300e6, load = 100e3;  // Pa/m, N
  const double inertia = width * height * height * height / 12;
  const auto [w, moment] = beam_on_bed(modulus * width, concrete.young * inertia, load);
  const double stress = moment * height / 2 / inertia;
  const Bedded coarse = bedded(sleeper(), modulus, load), fine = bedded(sleeper(2), modulus, load);
  const verified::Tolerance shears{0.03,
                                   "shear, which that beam neglects: 2 b^2 E I / k G A = 3 %"};
  const verified::Tolerance mesh{4e-3, "mesh: (b h)^2 / 12 = 1.3e-3, b = 1.2/m, three times"};
  verified::near("deflection on a bed, elements of 0.1 m", "m", coarse.deflection, w, shears.of(w));
  verified::near("deflection on a bed, elements of 0.1 m against 0.05 m", "m", coarse.deflection,
                 fine.deflection, mesh.of(w));
  verified::near("bending stress beside the load, elements of 0.1 m", "Pa", coarse.bending_stress,
                 stress, shears.of(stress));
}

// Smooth load on a free bar of few elements: differences of the ends of runs with halved steps.
TEST(SolidSleeper, TimeIntegrationIsOfSecondOrder) {
  const auto end = [](double dt) {
    BodiesParameters p;
    p.bodies = {{.name = "bar",
                 .low = {0, 0, 0},
                 .high = {0.2, 1, 0.2},
                 .elements = {1, 5, 1},
                 .solid = {.young = 1e8, .poisson = 0.2, .density = 2500}}};
    Bodies bodies(p);
    bodies.place(Vec3::Zero());
    Bodies::PatchLoad push{bodies.over(0, Side::upper, {.x = {0.1, 0.1}, .y = {1, 1}}), {}};
    const double duration = 0.04;
    for (int n = 1; n <= std::lround(duration / dt); ++n) {
      const double s = std::sin(std::numbers::pi * n * dt / duration);
      push.force = {0, 0, 1e3 * s * s};
      bodies.advance(dt, 0, std::span(&push, 1), {});
    }
    return bodies.displacement(push.at).z();
  };
  const std::array ends{end(2e-4), end(1e-4), end(5e-5), end(2.5e-5)};
  const auto order_from = [&](std::size_t i) {
    return std::log2(std::abs(ends[i] - ends[i + 1]) / std::abs(ends[i + 1] - ends[i + 2]));
  };
  const verified::Tolerance order{
      0.15, "second order for any alpha; next term: the step over the period of the bar"};
  verified::near("order of the step, 0.2 to 0.05 ms", "-", order_from(0), 2, order);
  verified::near("order of the step, 0.1 to 0.025 ms", "-", order_from(1), 2, order);
}

// Both on springs and dashpots at the lower corners, under an oscillating seat force.
TEST(SolidSleeper, StiffEqualsRigid) {
  track::SleeperParameters given;
  given.count = 1, given.first = 0, given.width = width, given.height = height;
  given.length = length, given.density = concrete.density;
  given.free = {"x", "y", "z", "rx", "ry", "rz"};
  track::RigidSleepers rigid(given, Dimension::space, 1, 0);
  Body block = sleeper();
  block.solid.young *= 1e4, block.touched = true;
  BodiesParameters parameters;
  parameters.bodies = {block};
  Bodies solid(parameters);
  rigid.place(0), solid.place(Vec3::Zero());
  constexpr double dt = 2e-5, k = 10e6, c = 20e3, g = 9.81;
  const auto corner = [](const Vec3& at) {
    return std::abs(std::abs(at.x()) - width / 2) < 1e-3 &&
           std::abs(std::abs(at.y()) - length / 2) < 1e-3 && at.z() < height / 4;
  };
  const auto forces = [&](const Surface& surface) {
    std::vector<Vec3> force(surface.nodes(), Vec3::Zero());
    for (std::size_t n = 0; n < force.size(); ++n) {
      if (!corner(surface.position[n])) continue;
      const Vec3 u = surface.position[n] + surface.motion[n];
      const bool soft = surface.position[n].y() > 0;  // one end: so that it rolls
      force[n].z() = -(soft ? 0.5 : 1) * k * u.z() - c * surface.motion[n].z() / dt;
    }
    return force;
  };
  double gap = 0, turn_gap = 0, largest = 0, turned = 0;
  for (int n = 0; n < 5000; ++n) {
    const double seat = 50e3 * (1 - std::cos(2 * std::numbers::pi * n * dt / 0.05)) / 2;
    const std::vector<Vec3> on_rigid = forces(rigid.surfaces()[0]),
                            on_solid = forces(solid.surfaces()[0]);
    rigid.advance(dt, std::span(&seat, 1), {std::span<const Vec3>(on_rigid)}, g);
    const Bodies::PatchLoad push{solid.over(0, Side::upper, {.x = {-0.1, 0.1}, .y = {-0.1, 0.1}}),
                                 {0, 0, -seat}};
    solid.advance(dt, g, std::span(&push, 1), {std::span<const Vec3>(on_solid)});
    const track::SleeperState one = rigid.state(0);
    const BodyMotion other = solid.motion(0);
    gap = std::max(gap, std::abs(one.displacement.z() - other.displacement.z()));
    turn_gap = std::max(turn_gap, std::abs(one.rotation.x() - other.rotation.x()));
    largest = std::max(largest, std::abs(one.displacement.z()));
    turned = std::max(turned, std::abs(one.rotation.x()));
  }
  ASSERT_GT(turned, 1e-4);
  // The forces act one step apart: leapfrog uses those at the start of a step, Bossak's scheme
  // those at its end.
  const verified::Limit close{2.5e-3, "forces a step apart: omega dt = 2.5e-3 of a load of 20 Hz"};
  verified::below(
      "displacement of a stiff solid relative to a rigid sleeper, over that of the sleeper", "-",
      gap / largest, close);
  verified::below("roll of a stiff solid relative to a rigid sleeper, over that of the sleeper",
                  "-", turn_gap / turned, close);
}

}  // namespace
}  // namespace trackbed::fem::bodies_verify_test
