// A plate that is moved along and against a sphere which is held: tangential force over
// displacement, the work of closed loops, and how far both are from partial slip (Mindlin,
// Deresiewicz 1953, doi:10.1115/1.4010702), which the law does not follow: all of its contact
// sticks or slides.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "impacts.hpp"
#include "partial_slip.hpp"
#include "support/verified.hpp"

namespace trackbed {
namespace {

constexpr double deepest = 1e-5;  // m, a thousandth of the radius
// Positions of 0.01 m are rounded by 1e-18 m and overlaps of 1e-5 m are their differences.
constexpr double rounding = 1e-12;
// 1000 springs side by side instead of all, twice the 6e-7 that are measured, of mu N.
constexpr double springs_error = 1.2e-6;

impacts::Ball steel() {
  return {.young = 70e9,
          .poisson = 0.25,
          .radius = 0.01,
          .friction = 0.3,
          .plate_young = 70e9,
          .plate_poisson = 0.25};
}

slip::Sphere sphere_of(const impacts::Ball& b) {
  return {b.radius, b.e_star(), b.g_star(), b.friction};
}

// The sphere and its plate, which moves by steps that take no time: no force depends on it.
class Rig {
 public:
  Rig() : particles_(impacts::nothing(steel())), plate_(test::floor_of(1, 0.1)) {
    dem::NewParticle ball;
    ball.scale = ball.position.z() = steel().radius, ball.held = true;
    particles_.add(std::span(&ball, 1));
    plate_.material = 1;
    particles_.set_surfaces({&plate_});
  }
  // Slip along x and growth of the overlap, m; returns the force along x on the ball, N.
  double move(double along, double deeper) {
    plate_.motion.assign(plate_.nodes(), Vec3(along, 0, deeper));
    particles_.advance(1e-9, 1);
    for (Vec3& x : plate_.position) x += plate_.motion[0];
    return particles_[0].force.x();
  }
  void press(double overlap) {
    for (int k = 0; k < 100; ++k) move(0, overlap / 100);
  }
  double normal() const { return particles_[0].force.z(); }

 private:
  dem::Particles particles_;
  Surface plate_;
};

// Displacements of the plate from 0 to each of `ends` in turn, in steps of this length; `see` is
// shown displacement and force.
template <class See>
void drive(Rig& rig, const std::vector<double>& ends, double step, See&& see) {
  double at = 0;
  for (const double end : ends) {
    const double from = at;
    const auto steps = std::lround(std::abs(end - from) / step);
    for (long k = 1; k <= steps; ++k) {
      const double now = from + (end - from) * static_cast<double>(k) / static_cast<double>(steps);
      const double force = rig.move(now - at, 0);
      see(at = now, force);
    }
  }
}

TEST(TangentialLoad, SticksWithMindlinsStiffnessUpToTheLimit) {
  const slip::Sphere s = sphere_of(steel());
  Rig rig;
  rig.press(deepest);
  const double normal = s.normal(deepest), limit = s.limit(deepest);
  verified::near("normal force over 4/3 E* a delta", "-", rig.normal() / normal, 1, rounding);
  double stuck = 0, slid = 0;
  drive(rig, {3 * limit}, limit / 50, [&](double u, double force) {
    const double error = std::abs(force / (s.mu * normal) - std::min(u / limit, 1.0));
    double& worst = u < 0.999 * limit ? stuck : slid;
    worst = std::max(worst, error);
  });
  verified::below("force against 8 G* a u, largest error over mu N", "-", stuck, rounding);
  verified::below("force against mu N, largest error over mu N", "-", slid, rounding);
}

// Work of the plate in the closed part of 0, +u, -u, +u, over mu N `gross`; the trapezoid rule is
// exact, since the force has its corners at the ends of steps.
double work_of_loop(double amplitude) {
  const slip::Sphere s = sphere_of(steel());
  const double gross = s.gross(deepest), u = amplitude * gross;
  Rig rig;
  rig.press(deepest);
  double work = 0, at = 0, before = 0;
  int reversals = 0;
  drive(rig, {u, -u, u}, gross / 75, [&](double now, double force) {
    if (reversals > 0) work += 0.5 * (force + before) * (now - at);
    at = now, before = force;
    if (std::abs(std::abs(now) - u) < 1e-6 * u) ++reversals;
  });
  return work / (s.mu * s.normal(deepest) * gross);
}

// Of the rule a parallelogram, 4 mu N (u - mu N / k), and nothing below the limit, which is at 2/3
// of `gross`; partial slip loses 8/15 mu N gross less where all slips in the end, and something in
// each loop that ends before.
TEST(TangentialLoad, WorkOfALoopIsThatOfItsParallelogram) {
  for (const double amplitude : {0.8, 1.0, 1.6, 3.2}) {
    const double work = work_of_loop(amplitude);
    const std::string at = fmt::format(", amplitude {:g}", amplitude);
    verified::near("work over mu N gross" + at, "-", work, 4 * (amplitude - 2.0 / 3), rounding);
    if (amplitude >= 1)
      verified::near("more than of partial slip" + at, "-", work - slip::loop_work(amplitude),
                     8.0 / 15, rounding);
  }
  for (const double amplitude : {0.2, 0.4, 0.6}) {
    const double work = work_of_loop(amplitude);
    const std::string at = fmt::format(", amplitude {:g}", amplitude);
    verified::near("work over mu N gross" + at, "-", work, 0, rounding);
    verified::near("less than of partial slip" + at, "-", slip::loop_work(amplitude) - work,
                   slip::loop_work(amplitude), rounding);
  }
}

// Loading 3/2 x against 1 - (1 - x)^(3/2), x over `gross`: farthest at x = 2/3, by 3^(-3/2) of mu
// N; twice that after a reversal.
TEST(TangentialLoad, DistanceFromPartialSlip) {
  const slip::Sphere s = sphere_of(steel());
  const double limit = s.mu * s.normal(deepest), gross = s.gross(deepest), u = 2 * gross;
  Rig rig;
  rig.press(deepest);
  double first = 0, second = 0, last = 0;
  bool back = false;
  drive(rig, {u, -u}, gross / 75, [&](double now, double force) {
    back |= now < last, last = now;
    const double x = now / gross;
    const double partial = back ? 1 - 2 * slip::first_loading((2 - x) / 2) : slip::first_loading(x);
    double& worst = back ? second : first;
    worst = std::max(worst, std::abs(force / limit - partial));
  });
  verified::near("largest distance over mu N, loading", "-", first, std::pow(3.0, -1.5), rounding);
  verified::near("largest distance over mu N, after a reversal", "-", second,
                 2 * std::pow(3.0, -1.5), rounding);
}

// The reference for loads of which there is no closed form, against that where there is one.
TEST(TangentialLoad, SpringsSideBySideSlipInPart) {
  const slip::Sphere s = sphere_of(steel());
  const double limit = s.mu * s.normal(deepest), gross = s.gross(deepest);
  slip::Springs springs(s, deepest, 1000);
  double worst = 0;
  springs.move(deepest, 0);
  for (int k = 1; k <= 100; ++k) {
    const double force = springs.move(deepest, 0.01 * gross) / limit;
    worst = std::max(worst, std::abs(force - slip::first_loading(0.01 * k)));
  }
  for (int k = 1; k <= 200; ++k) {
    const double force = springs.move(deepest, -0.01 * gross) / limit;
    worst = std::max(worst, std::abs(force - 1 + 2 * slip::first_loading(0.005 * k)));
  }
  verified::below("distance from Mindlin's and Deresiewicz's forms, over mu N", "-", worst,
                  springs_error);
}

struct Forces {
  double law, partial;  // over mu N at the deepest
};

// The same history of slip and overlap of both: to (slip, overlap), then to the next, in `steps`
// each.
Forces after(const std::vector<std::pair<double, double>>& ends, int steps) {
  const slip::Sphere s = sphere_of(steel());
  Rig rig;
  slip::Springs springs(s, deepest, 1000);
  double slipped = 0, overlap = 0;
  Forces f{};
  for (const auto& [to, depth] : ends) {
    const double way = (to - slipped) / steps, deeper = (depth - overlap) / steps;
    for (int k = 0; k < steps; ++k) {
      overlap += deeper;
      f = {rig.move(way, deeper), springs.move(overlap, way)};
    }
    slipped = to, overlap = depth;
  }
  const double limit = s.mu * s.normal(deepest);
  return {f.law / limit, f.partial / limit};
}

TEST(TangentialLoad, WithANormalForceThatVaries) {
  const double gross = sphere_of(steel()).gross(deepest), stuck = 0.1 * gross, half = deepest / 2;
  const double root = std::sqrt(0.5);
  // At half the overlap: the stiffness is root of that at the deepest, and so is the force of a
  // stretch that is kept; what has been loaded at half the overlap is kept while the overlap grows.
  const Forces fallen = after({{0, deepest}, {stuck, deepest}, {stuck, half}}, 1000);
  verified::near("force over mu N, normal force fallen", "-", fallen.law, 0.15 * root, rounding);
  const Forces risen = after({{0, half}, {stuck, half}, {stuck, deepest}}, 1000);
  verified::near("force over mu N, normal force risen", "-", risen.law, 0.15 * root, rounding);
  const Forces both =
      after({{0, deepest}, {stuck, deepest}, {stuck, half}, {stuck, deepest}}, 1000);
  verified::near("force over mu N, fallen and risen", "-", both.law, 0.15 * root, rounding);
  // Of springs side by side those that are left keep their forces, at the limit near the edge.
  const auto distance = [](const std::string& of, const Forces& f, double wanted) {
    verified::near("above that of partial slip over mu N, " + of, "-", f.law - f.partial, wanted,
                   springs_error);
  };
  const double at_half = 0.1 / 0.5;  // stuck over gross at half the overlap, where mu N is root^3
  distance("normal force risen", risen,
           0.15 * root - root * root * root * slip::first_loading(at_half));
  distance("normal force fallen", fallen,
           0.15 * root - root * root * root * slip::first_loading(at_half));
}

// Slip and overlap grow together from nothing. Below the slope of `gross` nothing slips, in part or
// as a whole, and F = 16/3 G* sqrt(R) (slip/overlap) delta^(3/2); above all slips.
TEST(TangentialLoad, WithANormalForceThatGrowsAlong) {
  const double gross = sphere_of(steel()).gross(deepest);
  for (const double slope : {0.5, 0.9}) {
    const Forces f = after({{slope * gross, deepest}}, 2000);
    const std::string at = fmt::format(", slope {:g}", slope);
    // The stiffness at the end of each step counts for all of it: 3/4 of a step's share.
    verified::near("force over mu N" + at, "-", f.law, slope, 1.5 * 0.75 / 2000 * slope);
    verified::near("force of partial slip over mu N" + at, "-", f.partial, slope, 2e-4);
  }
  verified::near("force over mu N, slope 1.2", "-", after({{1.2 * gross, deepest}}, 2000).law, 1,
                 rounding);
}

}  // namespace
}  // namespace trackbed
