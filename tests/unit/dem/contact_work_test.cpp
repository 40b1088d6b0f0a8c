// Work of one contact over closed motions: for any history, it never returns more work than it
// received. The motions are prescribed, so that only the law is tested.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>

#include "dem/law/laws.hpp"
#include "trackbed/core/hash.hpp"

namespace trackbed::dem::contact_work_test {
namespace {

constexpr double young = 1e9, radius = 0.02, root_mass = 0.2;  // Pa, m, sqrt(kg)
constexpr double heavy = 1e9;     // sqrt(kg): bodies with prescribed motion
constexpr double deepest = 1e-4;  // m

// Laws of many nu and restitutions, one half linear; a third with attraction, one half with rolling
// resistance.
std::vector<Law> some_laws() {
  std::vector<Law> laws;
  for (std::uint64_t k = 0; k < 48; ++k) {
    ContactLaw law{.first = "a", .second = "a"};
    law.kind = k % 2 ? LawKind::hertz : LawKind::linear;
    law.attraction = k % 3 == 0;
    law.restitution = k % 8 < 2 ? 1 : 0.1 + 0.9 * uniform(3, k);
    law.k_n = young * radius, law.k_s = (0.2 + uniform(4, k)) * law.k_n;
    law.zeta_n = linear_damping(law.restitution, !law.attraction);
    law.zeta_s = 2 * uniform(5, k) * law.zeta_n;
    law.rolling_friction = k % 16 < 8 ? 0.5 * uniform(6, k) : 0;
    law.rolling_stiffness = 0.1 + uniform(7, k), law.zeta_r = k % 8 < 2 ? 0 : uniform(8, k);
    Physics physics;
    physics.materials = {{.name = "a", .young = young, .poisson = 0.001 + 0.498 * uniform(1, k)}};
    physics.laws = {law};
    laws.push_back(LawTable(physics)[0]);
  }
  return laws;
}

// Sine of the whole circle divided into `steps`.
struct Circle {
  explicit Circle(int steps) : sine(static_cast<std::size_t>(steps)) {
    for (std::size_t k = 0; k < sine.size(); ++k)
      sine[k] = std::sin(2 * M_PI * static_cast<double>(k) / steps);
  }
  double at(std::size_t k) const { return sine[k % sine.size()]; }
  std::vector<double> sine;
};

// A closed course: three harmonics.
struct Course {
  double size = 0;
  std::array<double, 3> with_sine{}, with_cosine{};
  double at(const Circle& circle, std::size_t step) const {
    double sum = 0;
    for (std::size_t m = 0; m < 3; ++m)
      sum += with_sine[m] * circle.at((m + 1) * step) +
             with_cosine[m] * circle.at((m + 1) * step + circle.sine.size() / 4);
    return size * sum;
  }
};

// Motion of a contact: overlap, slip in two directions, relative spin of the bodies about the
// normal, mean spin about it, rolling in two directions; its spread changes.
enum Part : std::size_t {
  overlap,
  slip_x,
  slip_y,
  twisting,
  turning,
  roll_x,
  roll_y,
  spread,
  parts
};

struct Loop {
  Law law;
  std::array<Course, parts> part;
  double time;  // s
  double at(Part p, const Circle& circle, std::size_t step) const {
    const double value = part[p].at(circle, step);
    if (p != overlap) return p == spread ? value * value : value;
    // Open at both ends; where the harmonics are large also in between.
    const double middle = 0.5 - 0.5 * circle.at(step + circle.sine.size() / 4);
    return middle * (deepest + value) - 0.1 * deepest;
  }
};

// `key`: number of the loop. Slips and rotations from far below to far above what a spring carries.
Loop random_loop(const std::vector<Law>& laws, std::uint64_t key, bool turns) {
  Loop loop{.law = laws[key % laws.size()], .part = {}, .time = 0};
  std::uint64_t draw = 100;
  const auto random = [&] { return uniform(draw++, key); };
  loop.law.springs.mu = key % 5 == 0 ? 0 : 5 * random() * random();
  for (Course& c : loop.part)
    for (std::size_t m = 0; m < 3; ++m)
      c.with_sine[m] = 2 * random() - 1, c.with_cosine[m] = 2 * random() - 1;
  const auto decades = [&](double n) { return std::pow(10.0, n * (random() - 0.5)); };
  const double slip = deepest * decades(3), ring = 0.2 * radius * random();
  loop.part[overlap].size = 0.5 * deepest;
  loop.part[slip_x].size = slip, loop.part[slip_y].size = slip * decades(1);
  loop.part[twisting].size = deepest / radius * decades(3);
  loop.part[turning].size = turns ? 0.3 * random() : 0;
  loop.part[roll_x].size = loop.part[roll_y].size = deepest / radius * decades(3);
  loop.part[spread].size = ring;
  // Eight in a row take the same time, so that they have the step of the lanes in common.
  const double decade = 2 * uniform(99, key / lanes) - 1;
  loop.time = 30 * root_mass / std::sqrt(young * radius) * std::pow(10.0, decade);
  return loop;
}

template <class Real>
struct Contact {
  Triple<Real> xi{}, roll{};
  Real turn{}, size{}, ring{};
};

template <class Real>
struct Response {
  Triple<Real> friction{}, against_rolling{};
  Real normal{}, torsion{};
};

// Motion in a step, from one number or eight.
template <class Real>
struct Move {
  Springs<Real> springs;
  Rolling<Real> rolling;
  Triple<Real> n, sliding, spin;
  Real delta, rate, twisting, turning, spread;
};

// One step of the law as in the kernels (stone_law.hpp); `dt` is a number in each of them.
template <class Real>
Response<Real> respond(const Move<Real>& m, double dt, Contact<Real>& h) {
  const Real weight = Real{} + root_mass, moved = Real{} + heavy, r = Real{} + radius;
  const auto c = coefficients<true>(m.springs, m.delta, weight, r);
  const NormalSpring<Real> spring = spring_force<true>(
      m.springs, c, OverlapMotion<Real>{m.delta, m.rate}, end_mass(moved * moved), r, dt);
  const Touch<Real> touch{m.n, m.sliding + m.rate * m.n, m.delta, m.turning};
  const Real softer = softening(h.size, c.size), ring = c.size * m.spread;
  const Twisting<Real> face{root(m.spread), m.twisting, softening(h.ring, ring)};
  const auto contact = face_force(c, touch, spring, softer, face, dt, h.xi, h.turn);
  Response<Real> out{contact.friction, {}, contact.normal, contact.moment};
  const Rolls<Real> rolls{m.n, m.spin, m.turning, contact.normal, contact.next, c.k_n, r, weight};
  out.against_rolling = rolling_moment(m.rolling, rolls, softer, dt, h.roll).moment;
  h.size = c.size, h.ring = ring;
  return out;
}

const Triple<double> normal{2.0 / 7, 3.0 / 7, 6.0 / 7}, along{6.0 / 7, 2.0 / 7, -3.0 / 7},
    across{-3.0 / 7, 6.0 / 7, -2.0 / 7};

// The state of a loop at a step; moves are differences of states.
using State = std::array<double, parts>;

State state_of(const Loop& loop, const Circle& circle, std::size_t step) {
  State state;
  for (std::size_t p = 0; p < parts; ++p) state[p] = loop.at(static_cast<Part>(p), circle, step);
  return state;
}

Move<double> move_of(const Loop& loop, const State& before, const State& now, double dt) {
  const auto rate = [&](Part p) { return (now[p] - before[p]) / dt; };
  return {loop.law.springs,
          loop.law.rolling,
          normal,
          rate(slip_x) * along + rate(slip_y) * across,
          rate(roll_x) * along + rate(roll_y) * across,
          now[overlap],
          rate(overlap),
          rate(twisting),
          rate(turning),
          now[spread]};
}

// Work done on a contact in one step, J, by the trapezoid rule, and the sum of absolute values.
struct Work {
  double sum = 0, size = 0;
  void add(const Response<double>& before, const Response<double>& after, const Move<double>& m,
           double dt) {
    const double part[] = {0.5 * dt * m.rate * (before.normal + after.normal),
                           -0.5 * dt * dot(m.sliding, before.friction + after.friction),
                           -0.5 * dt * m.twisting * (before.torsion + after.torsion),
                           -0.5 * dt * dot(m.spin, before.against_rolling + after.against_rolling)};
    for (const double work : part) sum += work, size += std::abs(work);
  }
  double returned() const { return size > 0 ? -sum / size : 0; }  // > 0: more than received
};

// Runs a loop; `visit` is called for every move with the contact's state and response after it.
template <class Visit>
Work run(const Loop& loop, const Circle& circle, const Visit& visit) {
  Work work;
  Contact<double> contact;
  Response<double> before;
  const std::size_t steps = circle.sine.size();
  const double dt = loop.time / static_cast<double>(steps);
  State last = state_of(loop, circle, 0);
  for (std::size_t step = 1; step <= steps; ++step) {
    const State now = state_of(loop, circle, step);
    const Move<double> m = move_of(loop, last, now, dt);
    Response<double> after;
    if (m.delta > 0)
      after = respond(m, dt, contact);
    else
      contact = {};
    work.add(before, after, m, dt);
    visit(m, contact, after);
    before = after, last = now;
  }
  return work;
}

constexpr auto nothing = [](const auto&, const auto&, const auto&) {};

// Largest fraction of the work that is returned in excess in `loops` loops.
double most_returned(std::uint64_t loops, int steps, bool turns) {
  const std::vector<Law> laws = some_laws();
  const Circle circle(steps);
  double most = -1;
  for (std::uint64_t key = 0; key < loops; ++key)
    most = std::max(most, run(random_loop(laws, key, turns), circle, nothing).returned());
  return most;
}

// Largest fraction of the work gained or lost by normal forces alone without damping, of one kind.
double largest_error(std::uint64_t loops, int steps, bool hertz) {
  const Circle circle(steps);
  std::vector<Law> laws = some_laws();
  std::erase_if(laws, [&](const Law& law) {
    return law.springs.c_n > 0 || law.rolling.mu > 0 || (law.springs.hertz > 0) != hertz;
  });
  for (Law& law : laws) law.springs.mu = 0;
  double most = 0;
  for (std::uint64_t key = 0; key < loops; ++key) {
    Loop loop = random_loop(laws, key, false);
    loop.law.springs.mu = 0;
    most = std::max(most, std::abs(run(loop, circle, nothing).returned()));
  }
  return most;
}

// The trapezoid rule's own error: it falls with the square of the step (next test). Measured over
// these 1e5 loops: 12.0 / steps^2 as a fraction of all the work done; half as much again for other
// machines' sines. A law that generates energy returns 0.1 and more.
double tolerance(int steps) { return 18.0 / (steps * steps); }

TEST(ContactWork, NoClosedMotionReturnsMoreThanItReceived) {
  EXPECT_LT(most_returned(100000, 96, true), tolerance(96));
}

// So it vanishes in the limit.
TEST(ContactWork, ExcessWorkFallsWithTheSquareOfTheStep) {
  const double coarse = most_returned(10000, 48, true), middle = most_returned(10000, 96, true),
               fine = most_returned(10000, 192, true);
  EXPECT_GT(fine, 0);
  EXPECT_NEAR(coarse / middle, 4, 0.8);
  EXPECT_NEAR(middle / fine, 4, 0.4);
  EXPECT_LT((4 * fine - middle) / 3, 0.05 * fine);  // Richardson
}

// Normal forces without damping neither generate nor absorb work. Second order for Hertz, whose
// force is not linear in the overlap; third for linear springs, which have an error only where
// contacts open or close, by the change of speed in a step.
TEST(ContactWork, ElasticNormalForcesReturnAllTheirWork) {
  const auto ratio = [](bool hertz) {
    return largest_error(1000, 96, hertz) / largest_error(1000, 192, hertz);
  };
  EXPECT_NEAR(ratio(true), 4, 0.4);
  EXPECT_NEAR(ratio(false), 8, 1.5);
}

// Eight loops in lanes compared with the same loops one by one.
void put(Lanes& lane, std::size_t k, double value) { lane[k] = value; }

void put(Triple<Lanes>& lane, std::size_t k, const Triple<double>& v) {
  lane.x[k] = v.x, lane.y[k] = v.y, lane.z[k] = v.z;
}

void put(Move<Lanes>& to, std::size_t k, const Move<double>& m) {
  const Springs<double>& s = m.springs;
  put(to.springs.k_n, k, s.k_n), put(to.springs.k_s, k, s.k_s);
  put(to.springs.c_n, k, s.c_n), put(to.springs.c_s, k, s.c_s);
  put(to.springs.mu, k, s.mu), put(to.springs.least, k, s.least);
  put(to.springs.hertz, k, s.hertz);
  put(to.rolling.mu, k, m.rolling.mu), put(to.rolling.zeta, k, m.rolling.zeta);
  put(to.rolling.stiffness, k, m.rolling.stiffness);
  put(to.n, k, m.n), put(to.sliding, k, m.sliding), put(to.spin, k, m.spin);
  put(to.delta, k, m.delta), put(to.rate, k, m.rate), put(to.twisting, k, m.twisting);
  put(to.turning, k, m.turning), put(to.spread, k, m.spread);
}

void put(Contact<Lanes>& to, std::size_t k, const Contact<double>& c) {
  put(to.xi, k, c.xi), put(to.roll, k, c.roll);
  put(to.turn, k, c.turn), put(to.size, k, c.size), put(to.ring, k, c.ring);
}

// All quantities that a step changes and returns, in one row.
template <class Real>
std::array<Real, 17> row(const Contact<Real>& c, const Response<Real>& f) {
  return {c.xi.x,
          c.xi.y,
          c.xi.z,
          c.roll.x,
          c.roll.y,
          c.roll.z,
          c.turn,
          c.size,
          c.ring,
          f.friction.x,
          f.friction.y,
          f.friction.z,
          f.normal,
          f.against_rolling.x,
          f.against_rolling.y,
          f.against_rolling.z,
          f.torsion};
}

struct Record {
  Move<double> move;
  Contact<double> before, after;
  Response<double> response;
};

std::vector<Record> record(const Loop& loop, const Circle& circle) {
  std::vector<Record> all;
  Contact<double> before;
  run(loop, circle, [&](const auto& move, const auto& after, const auto& response) {
    all.push_back({move, before, after, response});
    before = after;
  });
  return all;
}

TEST(ContactWork, EightInLanesAreBitwiseIdenticalToOne) {
  const std::vector<Law> laws = some_laws();
  constexpr int steps = 48;
  const Circle circle(steps);
  std::size_t closed = 0, differ = 0;
  for (std::uint64_t first = 0; first < 10000; first += lanes) {
    std::array<std::vector<Record>, lanes> one;
    for (std::size_t k = 0; k < lanes; ++k)
      one[k] = record(random_loop(laws, first + k, true), circle);
    const double dt = random_loop(laws, first, true).time / steps;
    for (std::size_t step = 0; step < steps; ++step) {
      Move<Lanes> move;
      Contact<Lanes> contact;
      for (std::size_t k = 0; k < lanes; ++k)
        put(move, k, one[k][step].move), put(contact, k, one[k][step].before);
      const auto response = respond(move, dt, contact);
      const auto eight = row(contact, response);
      for (std::size_t k = 0; k < lanes; ++k) {
        if (one[k][step].move.delta <= 0) continue;
        ++closed;
        const auto single = row(one[k][step].after, one[k][step].response);
        for (std::size_t i = 0; i < single.size(); ++i)
          differ += std::bit_cast<std::uint64_t>(single[i]) !=
                    std::bit_cast<std::uint64_t>(static_cast<double>(eight[i][k]));
      }
    }
  }
  EXPECT_GT(closed, 200000U);
  EXPECT_EQ(differ, 0U);
}

}  // namespace
}  // namespace trackbed::dem::contact_work_test
