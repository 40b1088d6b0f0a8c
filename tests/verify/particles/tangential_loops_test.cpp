// A plate moved tangentially against a fixed sphere: tangential force over displacement, the work
// of closed loops, and the difference of both from partial slip (Mindlin, Deresiewicz 1953,
// doi:10.1115/1.4010702), which is not modelled: the whole contact sticks or slides.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "impacts.hpp"
#include "partial_slip.hpp"
#include "support/verified.hpp"

namespace trackbed::tangential_loops_test {
namespace {

constexpr double deepest = 1e-5;  // m, a thousandth of the radius
const verified::Tolerance rounding{
    1e-12, "rounding of places of 0.01 m, 2e-18 m, in overlaps of 1e-5 m: 2e-13, a few times"};
// Over mu N; h = 1e-3 of the contact's radius. The density of force has a corner where slip begins,
// with a jump of slope of 3, and of 6 after a reversal.
const verified::Tolerance discrete{
    1.2e-6, "1000 springs: h^2 / 8 of the jump of slope where slip begins, 3 to 6: 4e-7 to 8e-7"};

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

// The sphere and its plate, which moves in very short steps: no force depends on time.
class Rig {
 public:
  Rig() : particles_(impacts::nothing(steel())), plate_(test::floor_of(1, 0.1)) {
    dem::NewParticle ball;
    ball.scale = ball.position.z() = steel().radius, ball.held = true;
    particles_.add(std::span(&ball, 1));
    plate_.material = 1;
    particles_.set_surfaces({&plate_});
  }
  // Slip along x and increase of the overlap, m; returns the force along x on the ball, N.
  double move(double along, double deeper) {
    plate_.motion.assign(plate_.nodes(), Vec3(along, 0, deeper));
    particles_.advance(1e-9, 1);
    for (Vec3& x : plate_.position) x += plate_.motion[0];
    return particles_[0].force.x();
  }
  void compress(double overlap) {
    for (int k = 0; k < 100; ++k) move(0, overlap / 100);
  }
  double normal() const { return particles_[0].force.z(); }

 private:
  dem::Particles particles_;
  Surface plate_;
};

// Displaces the plate from 0 to each of `ends` in turn, in steps of this length; `observe` is
// called with displacement and force.
template <class Observer>
void drive(Rig& rig, const std::vector<double>& ends, double step, Observer&& observe) {
  double at = 0;
  for (const double end : ends) {
    const double from = at;
    const auto steps = std::lround(std::abs(end - from) / step);
    for (long k = 1; k <= steps; ++k) {
      const double now = from + (end - from) * static_cast<double>(k) / static_cast<double>(steps);
      const double force = rig.move(now - at, 0);
      observe(at = now, force);
    }
  }
}

TEST(TangentialLoad, SticksWithMindlinsStiffnessUpToTheLimit) {
  const slip::Sphere s = sphere_of(steel());
  Rig rig;
  rig.compress(deepest);
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

// Work of the plate in the closed part of 0, +u, -u, +u, over mu N `gross`; the trapezoidal rule is
// exact, since the force has its corners at the ends of steps.
double work_of_loop(double amplitude) {
  const slip::Sphere s = sphere_of(steel());
  const double gross = s.gross(deepest), u = amplitude * gross;
  Rig rig;
  rig.compress(deepest);
  double work = 0, at = 0, before = 0;
  int reversals = 0;
  drive(rig, {u, -u, u}, gross / 75, [&](double now, double force) {
    if (reversals > 0) work += 0.5 * (force + before) * (now - at);
    at = now, before = force;
    if (std::abs(std::abs(now) - u) < 1e-6 * u) ++reversals;
  });
  return work / (s.mu * s.normal(deepest) * gross);
}

// The law gives a parallelogram, 4 mu N (u - mu N / k), and zero below the limit, which is at 2/3
// of `gross`; partial slip dissipates 8/15 mu N gross less if the whole contact slips at the end,
// and a positive amount in each smaller loop.
TEST(TangentialLoad, WorkOfALoopIsThatOfItsParallelogram) {
  for (const double amplitude : {0.8, 1.0, 1.6, 3.2}) {
    const double work = work_of_loop(amplitude);
    const std::string at = fmt::format(", amplitude {:g}", amplitude);
    verified::near("work over mu N gross" + at, "-", work, 4 * (amplitude - 2.0 / 3), rounding);
    if (amplitude >= 1)
      verified::near("difference from partial slip" + at, "-", work - slip::loop_work(amplitude),
                     8.0 / 15, rounding);
  }
  for (const double amplitude : {0.2, 0.4, 0.6}) {
    const double work = work_of_loop(amplitude);
    const std::string at = fmt::format(", amplitude {:g}", amplitude);
    verified::near("work over mu N gross" + at, "-", work, 0, rounding);
    verified::near("partial slip minus law" + at, "-", slip::loop_work(amplitude) - work,
                   slip::loop_work(amplitude), rounding);
  }
}

// Loading 3/2 x against 1 - (1 - x)^(3/2), x over `gross`: the largest difference is 3^(-3/2) mu N
// at x = 2/3, and twice that after a reversal.
TEST(TangentialLoad, DifferenceFromPartialSlip) {
  const slip::Sphere s = sphere_of(steel());
  const double limit = s.mu * s.normal(deepest), gross = s.gross(deepest), u = 2 * gross;
  Rig rig;
  rig.compress(deepest);
  double first = 0, second = 0, last = 0;
  bool back = false;
  drive(rig, {u, -u}, gross / 75, [&](double now, double force) {
    back |= now < last, last = now;
    const double x = now / gross;
    const double partial = back ? 1 - 2 * slip::first_loading((2 - x) / 2) : slip::first_loading(x);
    double& worst = back ? second : first;
    worst = std::max(worst, std::abs(force / limit - partial));
  });
  verified::near("largest difference over mu N, loading", "-", first, std::pow(3.0, -1.5),
                 rounding);
  verified::near("largest difference over mu N, after a reversal", "-", second,
                 2 * std::pow(3.0, -1.5), rounding);
}

// The reference for loads without closed form, against the closed form for a simple load.
TEST(TangentialLoad, ParallelSpringsReproducePartialSlip) {
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
  verified::below("difference from the forms of Mindlin and Deresiewicz, over mu N", "-", worst,
                  discrete);
}

struct Forces {
  double law, partial;  // over mu N at the deepest
};

// Both with the same history of slip and overlap: to (slip, overlap), then to the next, in `steps`
// each.
Forces after(const std::vector<std::pair<double, double>>& ends, int steps) {
  const slip::Sphere s = sphere_of(steel());
  Rig rig;
  slip::Springs springs(s, deepest, 1000);
  double slipped = 0, overlap = 0;
  Forces f{};
  for (const auto& [to, depth] : ends) {
    const double slip = (to - slipped) / steps, deeper = (depth - overlap) / steps;
    for (int k = 0; k < steps; ++k) {
      overlap += deeper;
      f = {rig.move(slip, deeper), springs.move(overlap, slip)};
    }
    slipped = to, overlap = depth;
  }
  const double limit = s.mu * s.normal(deepest);
  return {f.law / limit, f.partial / limit};
}

TEST(TangentialLoad, WithAVariableNormalForce) {
  const double gross = sphere_of(steel()).gross(deepest), stuck = 0.1 * gross, half = deepest / 2;
  const double root = std::sqrt(0.5);
  // At half the overlap the stiffness is `root` times that at the deepest, and so is the force of a
  // constant spring displacement; a force loaded at half the overlap is kept while the overlap
  // grows.
  const Forces unloaded = after({{0, deepest}, {stuck, deepest}, {stuck, half}}, 1000);
  verified::near("force over mu N, decreasing normal force", "-", unloaded.law, 0.15 * root,
                 rounding);
  const Forces loaded = after({{0, half}, {stuck, half}, {stuck, deepest}}, 1000);
  verified::near("force over mu N, increasing normal force", "-", loaded.law, 0.15 * root,
                 rounding);
  const Forces both =
      after({{0, deepest}, {stuck, deepest}, {stuck, half}, {stuck, deepest}}, 1000);
  verified::near("force over mu N, decreasing and increasing", "-", both.law, 0.15 * root,
                 rounding);
  // Of the parallel springs those still in contact keep their forces, limited near the edge.
  const auto difference = [](const std::string& of, const Forces& f, double wanted) {
    verified::near("difference from partial slip over mu N, " + of, "-", f.law - f.partial, wanted,
                   discrete);
  };
  const double at_half =
      0.1 / 0.5;  // displacement over gross at half the overlap, where mu N is root^3
  difference("increasing normal force", loaded,
             0.15 * root - root * root * root * slip::first_loading(at_half));
  difference("decreasing normal force", unloaded,
             0.15 * root - root * root * root * slip::first_loading(at_half));
}

// Slip and overlap grow together from zero. Below the slope of `gross` there is neither partial nor
// gross slip, and F = 16/3 G* sqrt(R) (slip/overlap) delta^(3/2); above it the whole contact slips.
TEST(TangentialLoad, WithAProportionalNormalForce) {
  const double gross = sphere_of(steel()).gross(deepest);
  for (const double slope : {0.5, 0.9}) {
    const Forces f = after({{slope * gross, deepest}}, 2000);
    const std::string at = fmt::format(", slope {:g}", slope);
    const verified::Tolerance step{
        1.5 * 0.75 / 2000, "stiffness at the end of each of 2000 steps: 3/4 of a step, 1.5 times"};
    verified::near("force over mu N" + at, "-", f.law, slope, step.of(slope));
    // A spring that touches within a step has the slip of the whole step, limited by its own normal
    // force: in the mean slope (1 - slope)/2 of a step too much, of all springs 3/2 of it.
    const verified::Tolerance begin{1.5 / 2 / 2000,
                                    "springs touch within one of 2000 steps, twice"};
    verified::near("force of partial slip over mu N" + at, "-", f.partial, slope,
                   begin.of(2 * slope * (1 - slope)));
  }
  verified::near("force over mu N, slope 1.2", "-", after({{1.2 * gross, deepest}}, 2000).law, 1,
                 rounding);
}

}  // namespace
}  // namespace trackbed::tangential_loops_test
