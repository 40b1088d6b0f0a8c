// 1,000 elastic collisions without friction of stones, boxes and compounds with their true mass
// properties: corners, edges, faces, grazing, spinning.
//
// Velocity Verlet conserves a slightly different energy exactly while a linear spring acts; the
// error where the contact opens and closes is corrected (src/dem/contact/stone_law.hpp). The
// remaining error is of second order, since the overlap of a stone that turns is no straight line.
// It grows with dt sqrt(k / m_c), m_c the effective mass at the contact (of two equal spheres: half
// the mass of one; of a stone hit at a corner: down to an eighth of the lighter one), and is
// largest if a face rocks from one corner to the next within a sub-step. All bounds apply to dt =
// 0.1 sqrt(m / k), m the lighter body's mass; they are tighter with m_c in its place.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "support/stone_pairs.hpp"
#include "support/stones.hpp"
#include "support/verified.hpp"
#include "trackbed/core/rotation.hpp"

namespace trackbed::stones_energy_test {
namespace {

constexpr int collisions = 1000;
constexpr double density = 2600;  // kg/m^3

struct Collision {
  const dem::Template* shape[2];
  dem::NewParticle body[2];
  double k;  // N/m
};

struct Outcome {
  double error = 0;  // of the kinetic energy
  double lighter = 0,
         effective = 1e300;  // kg; of the lighter body; at the contact, least of the collision
  bool collided = false;
};

const std::vector<dem::Template>& library() {
  static const std::vector<dem::Template> shapes = [] {
    std::vector<dem::Template> all;
    for (std::uint64_t s = 0; s < 24; ++s) all.push_back(test::stone(s));
    for (std::uint64_t s = 24; s < 30; ++s) all.push_back(test::stone(s, 40, 0.03));
    for (int s = 0; s < 8; ++s) all.push_back(test::cuboid({0.5, 0.35 + 0.02 * s, 0.3}));
    for (std::uint64_t s = 0; s < 9; ++s) all.push_back(test::compound(s));
    return all;
  }();
  return shapes;
}

Vec3 draw(std::uint64_t seed, std::uint64_t key) {
  return Vec3(uniform(seed, key), uniform(seed + 1, key), uniform(seed + 2, key)) -
         Vec3::Constant(0.5);
}

Quat any_turn(std::uint64_t seed, std::uint64_t key) {  // Shoemake 1992
  const double u = uniform(seed, key), a = 2 * M_PI * uniform(seed + 1, key),
               b = 2 * M_PI * uniform(seed + 2, key);
  return {std::sqrt(1 - u) * std::sin(a), std::sqrt(1 - u) * std::cos(a),
          std::sqrt(u) * std::sin(b), std::sqrt(u) * std::cos(b)};
}

// Opposite faces, parallel within 0.01 rad.
void lay_faces_together(Collision& c, const Vec3& along, std::uint64_t key) {
  for (std::uint64_t n = 0; n < 2; ++n) {
    const auto& faces = c.shape[n]->pieces[0].core.faces;
    const auto face =
        static_cast<std::size_t>(uniform(50 + n, key) * static_cast<double>(faces.size()));
    const Vec3 to = (n == 0 ? along : Vec3(-along)) + 0.01 * draw(55 + 3 * n, key);
    c.body[n].attitude =
        Eigen::AngleAxisd(6 * uniform(61 + n, key), along) * rotation_onto(faces[face].normal, to);
  }
}

// Cyclically: any poses; fast spins; grazing; faces.
Collision collision(std::uint64_t key) {
  const auto& shapes = library();
  Collision c;
  for (std::uint64_t n = 0; n < 2; ++n) {
    const double count = static_cast<double>(shapes.size());
    c.shape[n] = &shapes[static_cast<std::size_t>(uniform(1 + n, key) * count)];
    c.body[n].id = static_cast<Id>(n);
    c.body[n].shape = static_cast<int>(n);
    c.body[n].scale = 0.03 + 0.02 * uniform(4 + n, key);
    c.body[n].attitude = any_turn(10 + 3 * n, key);
    if (key % 4 == 1) c.body[n].spin = 200 * draw(40 + 3 * n, key);
  }
  c.k = std::pow(10, 6 + 2.7 * uniform(3, key));  // overlaps of 0.1 to 10 % of the rounding
  const Vec3 along = any_turn(20, key) * Vec3::UnitZ(), side = along.unitOrthogonal();
  const bool grazing = key % 4 == 2;
  c.body[1].position = 0.2 * along + (grazing ? 0.012 : 0.003) * side;
  c.body[1].velocity =
      grazing ? Vec3(-0.3 * along + 1.5 * along.cross(side)) : Vec3(-along + 0.5 * draw(30, key));
  if (key % 4 == 3) lay_faces_together(c, along, key);
  constexpr double gap = 2e-6;  // m
  test::bring_near(*c.shape[0], c.body[0], *c.shape[1], c.body[1], gap);
  return c;
}

// 1 / m_c = sum over both bodies of 1 / m + t . I^-1 t, t the torque of a unit force.
double effective_mass(const dem::Particles& p, const Collision& c) {
  double inverse = 0;
  for (std::size_t n = 0; n < 2; ++n) {
    const dem::ParticleView v = p[n];
    const Vec3 torque = v.attitude.conjugate() * Vec3(v.torque / v.force.norm());
    const Vec3 gyration = v.scale * v.scale * c.shape[n]->gyration;
    inverse += (1 + torque.cwiseAbs2().cwiseQuotient(gyration).sum()) / v.mass;
  }
  return 1 / inverse;
}

// dt = fraction sqrt(mass / k), mass 0: that of the lighter body.
Outcome collide(const Collision& c, double fraction, double mass) {
  dem::ContactLaw law;
  law.k_n = c.k, law.k_s = 0, law.friction = 0;
  dem::Parameters parameters;
  parameters.gravity = 0, parameters.largest_overlap = 1e3;
  dem::Particles p(par::Comm::self(), test::one_material(law, density), parameters,
                   test::box(Vec3::Constant(-1), Vec3::Ones()));
  for (const dem::Template* shape : c.shape) p.add_template(*shape);
  p.add(std::vector(c.body, c.body + 2));
  Outcome outcome;
  outcome.lighter = std::min(p[0].mass, p[1].mass);
  const double dt = fraction * std::sqrt((mass > 0 ? mass : outcome.lighter) / c.k);
  const int few = std::max(1, static_cast<int>(0.3 / fraction));
  const double before = p.totals().kinetic;
  constexpr int separated = 30, never = 3000;
  for (int idle = 0; idle < (outcome.collided ? separated : never);) {
    p.advance(few * dt, few);
    ++idle;
    if (p.totals().contacts == 0) continue;
    outcome.collided = true, idle = 0;
    if (p[0].force.norm() > 0)
      outcome.effective = std::min(outcome.effective, effective_mass(p, c));
  }
  outcome.error = std::abs(p.totals().kinetic / before - 1);
  return outcome;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

TEST(StoneEnergy, ThousandCollisionsConserveIt) {
  constexpr double fractions[] = {0.1, 0.05, 0.025};
  const verified::Limit typical{
      4e-6, "2.1e-6, twice; 7.9e-6 with the mass of the centres at the ends of contacts"};
  const verified::Limit typical_effective{
      1e-6, "6.5e-7; 1.3e-6 with the mass of the centres at the ends of contacts"};
  const verified::Limit rocking{
      5e-3, "the largest of 1,000, 4.8e-3; rocking in a step allows dt^2 k / 2 m_c = 0.04"};
  const verified::Limit quarter{
      1.25e-3, "second order at least: a quarter of the limit with twice the step"};
  const verified::Limit rocking_effective{
      2e-3, "rocking in a step allows dt^2 k / 2 m_c = 5e-3; few do, half of it"};
  const verified::Tolerance orders{
      0.2, "the trapezoid's second; 2.8 and 2.5 with the mass of the centres at the ends"};
  std::map<double, std::vector<double>> by_lighter, by_effective;
  std::uint64_t key = 0;
  for (int collided = 0; collided < collisions; ++key) {
    const Collision c = collision(key);
    const Outcome first = collide(c, 0.05, 0);
    if (!first.collided) continue;
    ++collided;
    for (const double fraction : fractions) {
      by_lighter[fraction].push_back(collide(c, fraction, 0).error);
      by_effective[fraction].push_back(collide(c, fraction, first.effective).error);
    }
  }
  for (const auto& [name, errors] : {std::pair("lighter", by_lighter), {"effective", by_effective}})
    for (const double fraction : fractions) {
      const auto& e = errors.at(fraction);
      printf("dt = %.3f sqrt(m/k), m %s: median %.2e, largest %.2e\n", fraction, name, median(e),
             *std::max_element(e.begin(), e.end()));
    }
  const auto order = [&](const auto& errors) {
    return std::log(median(errors.at(0.1)) / median(errors.at(0.025))) / std::log(4.0);
  };
  const auto largest = [&](const auto& errors, double fraction) {
    return *std::max_element(errors.at(fraction).begin(), errors.at(fraction).end());
  };
  verified::below("median error, dt = 0.1 sqrt(m/k)", "-", median(by_lighter[0.1]), typical);
  verified::below("median error, m effective", "-", median(by_effective[0.1]), typical_effective);
  verified::below("largest error, dt = 0.1 sqrt(m/k)", "-", largest(by_lighter, 0.1), rocking);
  verified::below("largest error, dt = 0.05 sqrt(m/k)", "-", largest(by_lighter, 0.05), quarter);
  verified::below("largest error, m effective", "-", largest(by_effective, 0.1), rocking_effective);
  verified::near("order in dt", "-", order(by_lighter), 2, orders);
  verified::near("order in dt, m effective", "-", order(by_effective), 2, orders);
}

// Relative change of the energy of a stone that strikes a floor in steps of 0.2 sqrt(m / k), the
// default.
double struck(std::uint64_t key) {
  const dem::Template shape = test::irregular(0.02, 1e-3, key % 8);
  dem::ContactLaw law;
  law.k_n = 1e6, law.k_s = 0, law.friction = 0;
  dem::Parameters parameters;
  parameters.gravity = 0;
  dem::Particles p(par::Comm::self(), test::one_material(law, density), parameters,
                   test::box(Vec3::Constant(-1), Vec3::Ones()));
  p.add_template(shape);
  dem::NewParticle stone;
  stone.scale = 1, stone.attitude = any_turn(1, key), stone.spin = 60 * draw(5, key);
  stone.velocity = Vec3(0, 0, -0.4), stone.position = Vec3(0, 0, 0.03);
  p.add(std::span(&stone, 1));
  Surface floor = test::floor_of(1, 0.5);
  p.set_surfaces({&floor});
  const double before = p.totals().kinetic, dt = 0.2 * std::sqrt(p[0].mass / law.k_n);
  bool touched = false;
  for (int idle = 0; idle < (touched ? 30 : 100000);) {
    p.advance(dt, 1);
    ++idle;
    if (p.totals().contacts > 0) touched = true, idle = 0;
  }
  EXPECT_TRUE(touched) << key;
  return std::abs(p.totals().kinetic / before - 1);
}

TEST(StoneEnergy, StonesThatStrikeAFloorKeepIt) {
  std::vector<double> errors;
  for (std::uint64_t key = 0; key < 200; ++key) errors.push_back(struck(key));
  printf("floor: median %.2e, largest %.2e\n", median(errors),
         *std::max_element(errors.begin(), errors.end()));
  verified::below("median change of energy in a collision with a floor", "-", median(errors),
                  {1.2e-4, "6.1e-5, twice; 1.8e-4 with the mass of the centre at the ends"});
}

TEST(StoneEnergy, BoxesFaceToFace) {
  constexpr int boxes = 120;
  std::map<double, std::vector<double>> errors;
  for (std::uint64_t key = 0; key < boxes; ++key) {
    Collision c;
    for (std::uint64_t n = 0; n < 2; ++n) {
      c.shape[n] = &library()[30 + (key + n) % 8];
      c.body[n].id = static_cast<Id>(n), c.body[n].shape = static_cast<int>(n);
      c.body[n].scale = 0.04;
    }
    c.k = key % 2 ? 5e8 : 2e6;
    const Quat about(Eigen::AngleAxisd(key % 3 ? uniform(1, key) : 0.0, Vec3::UnitZ()));
    const Vec3 tilt = 1e-3 * draw(2, key);
    c.body[1].attitude = Quat(1, tilt.x(), tilt.y(), 0).normalized() * about;
    c.body[1].position = Vec3(0.02 * draw(5, key).x(), 0.02 * draw(5, key).y(), 0.06);
    c.body[1].velocity = Vec3(0.1 * draw(8, key).x(), 0.1 * draw(8, key).y(), -1);
    test::bring_near(*c.shape[0], c.body[0], *c.shape[1], c.body[1], 1e-6, -Vec3::UnitZ());
    for (const double fraction : {0.1, 0.05, 0.025}) {
      const Outcome o = collide(c, fraction, 0);
      EXPECT_TRUE(o.collided) << key;
      errors[fraction].push_back(o.error);
    }
  }
  for (const auto& [fraction, e] : errors)
    printf("faces, dt = %.3f sqrt(m/k): median %.2e, largest %.2e\n", fraction, median(e),
           *std::max_element(e.begin(), e.end()));
  verified::below("largest error, dt = 0.025 sqrt(m/k)", "-",
                  *std::max_element(errors[0.025].begin(), errors[0.025].end()),
                  {1e-3, "rocking in a step allows dt^2 k / 2 m_c = 2.5e-3 at m_c = m / 8"});
  const verified::Tolerance order{0.4, "rocking is of second order; the rest of third and more"};
  verified::near("order in dt", "-",
                 std::log(median(errors[0.1]) / median(errors[0.025])) / std::log(4.0), 2.2, order);
}

}  // namespace
}  // namespace trackbed::stones_energy_test
