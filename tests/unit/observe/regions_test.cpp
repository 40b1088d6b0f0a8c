// Packings with known density, stress and fabric.
#include "trackbed/observe/regions.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/scene.hpp"
#include "support/stones.hpp"

namespace trackbed::regions_test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double k_n = 1e6, r = 0.05, density = 2500;  // N/m, m, kg/m^3
constexpr double rounding = 1e-12;
// Relative, for sums over ranks: the error of each of N terms is at most 2^-61 of N times the
// largest (core/exact_sum.hpp). Here N < 4e5, of which half are of one kind, and sums are over 80
// of the largest (whole balls): 4e5 2e5 2^-61/80 = 4e-10.
constexpr double sum_rounding = 1e-9;
// Relative, for forces: an overlap is the difference of a few lengths of 0.1 m, each accurate to
// 2^-56 m = 1.4e-17 m, and is 1e-4 m or more: 1e-12.
constexpr double overlap_rounding = 1e-11;

dem::ContactLaw springs() {
  dem::ContactLaw law;
  law.k_n = law.k_s = k_n;
  law.friction = 0.5;
  return law;
}

observe::Region box(const std::vector<double>& x, const std::vector<double>& y,
                    const std::vector<double>& z) {
  observe::Region region;
  region.name = "box";
  region.x = x, region.y = y, region.z = z;
  return region;
}

// n^3 balls on a simple cubic lattice with spacing 2 r (1 - squeeze_a) along axis a, periodic in x
// and y, between a floor and a lid with the same contact force as between balls; displaced as a
// whole across the periodic sides.
struct Cubic {
  static constexpr int n = 6;
  Vec3 d;
  double foot;  // m: the overlap with the floor is that between balls
  Surface floor, lid;
  dem::Particles particles;

  explicit Cubic(const par::Comm& comm, const Vec3& squeeze = {0.002, 0.003, 0.004},
                 const Vec3& moved = Vec3::Zero())
      : d(2 * r * (Vec3::Ones() - squeeze)),
        foot(r - d.z() / 2),
        floor(test::floor_of(1, 10, foot, "floor")),
        lid(test::floor_of(1, 10, n * d.z() - foot, "lid")),
        particles(comm, test::one_material(springs(), density), {.gravity = 0}, domain(d)) {
    for (auto& t : lid.triangles) std::swap(t[1], t[2]);  // faces down
    particles.add_template(test::sphere());
    std::vector<dem::NewParticle> all;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        for (int k = 0; k < n; ++k) {
          dem::NewParticle p;
          p.id = static_cast<Id>(all.size());
          p.scale = r;
          p.position = d.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5)) + moved;
          all.push_back(p);
        }
    particles.add(test::mine(comm, all));
    particles.set_surfaces({&floor, &lid});
    particles.advance(1e-12, 1);
  }
  static dem::Domain domain(const Vec3& d) {
    dem::Domain domain = test::box({0, 0, -1}, {n * d.x(), n * d.y(), 1 + n * d.z()});
    domain.periodic = {true, true, false};
    return domain;
  }
  // Pa: k times overlap over the area per ball.
  Vec3 stress() const {
    const Vec3 force = k_n * (Vec3::Constant(2 * r) - d);
    return -Vec3(force.x() / (d.y() * d.z()), force.y() / (d.x() * d.z()),
                 force.z() / (d.x() * d.y()));
  }
};

// A ball that hangs from a held one by a bond alone: the tension carries its weight.
TEST(Regions, BondsCarryTension) {
  dem::Physics physics = test::one_material(springs(), density);
  physics.materials[0].local_damping = 0.8;
  dem::Particles particles(par::Comm::self(), physics, {},
                           test::box(Vec3::Constant(-1), Vec3::Constant(1)));
  dem::BondParameters glue;
  glue.gap = 1e-5;
  particles.set_bonds({glue});
  particles.add_template(test::sphere());
  std::vector<dem::NewParticle> two(2);
  for (std::size_t k = 0; k < 2; ++k) {
    two[k].id = static_cast<Id>(k), two[k].scale = r;
    two[k].position = Vec3(0, 0, -2.0001 * r * static_cast<double>(k));
  }
  two[0].held = true;
  particles.add(two);
  particles.set_surfaces({});
  ASSERT_EQ(particles.bond(0), 1);
  const double dt = particles.stable_step();
  particles.advance(2000 * dt, 2000);
  const auto region = box({-0.1, 0.1}, {-0.1, 0.1}, {-0.2, 0.1});
  const observe::Measurement m = observe::measure(par::Comm::self(), particles, region).at(0);
  const double weight = particles[1].mass * gravity, length = -particles[1].position.z();
  EXPECT_NEAR(m.stress[2], weight * length / (0.2 * 0.2 * 0.3), 1e-6 * m.stress[2]);
  EXPECT_EQ(m.contacts, 0);
}

TEST(Regions, ACubicPackHasTheStressOnItsWalls) {
  const par::Comm world = par::Comm::world();
  const Cubic pack(world, {0.002, 0.003, 0.004}, {0.13, -1.7, 0});
  const Vec3 size = Cubic::n * pack.d;
  // Whole periods across: for any position of the box and any cut through the lattice.
  for (const double shift : {0.0, 0.0371, -2.0})
    for (const auto& z :
         {std::vector{pack.foot, size.z() - pack.foot}, {0.11, 0.35}, {0.05, 0.051}}) {
      auto region = box({shift, size.x() + shift}, {shift, size.y() + shift}, z);
      const observe::Measurement m = observe::measure(world, pack.particles, region).at(0);
      const Vec3 wanted = pack.stress();
      EXPECT_NEAR(m.stress[2], wanted.z(), 1e-9 * std::abs(wanted.z())) << shift << " " << z[0];
      for (int k = 3; k < 6; ++k)
        EXPECT_NEAR(m.stress[static_cast<std::size_t>(k)], 0, 1e-9 * wanted.norm());
    }
  // Whole lattice cells: all components, numbers and densities. Borders avoid centres of balls and
  // contacts, which would otherwise be on either side by rounding.
  auto region = box({0, size.x()}, {0, size.y()}, {1.25 * pack.d.z(), 4.25 * pack.d.z()});
  const observe::Measurement m = observe::measure(world, pack.particles, region).at(0);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(m.stress[static_cast<std::size_t>(k)], pack.stress()[k], 1e-9 * 1e6);
    EXPECT_NEAR(m.fabric[static_cast<std::size_t>(k)], 1.0 / 3, sum_rounding);
  }
  EXPECT_EQ(m.stones, 3 * Cubic::n * Cubic::n);
  EXPECT_NEAR(m.coordination, 6, rounding);
  EXPECT_NEAR(m.fabric[0] + m.fabric[1] + m.fabric[2], 1, rounding);
  const double solid = 4.0 / 3 * pi * r * r * r / pack.d.prod();
  // Parts cut off at one border are included at the other, so the errors of the points cancel.
  EXPECT_NEAR(m.porosity, 1 - solid, sum_rounding);
  EXPECT_NEAR(m.bulk_density, solid * density, sum_rounding * solid * density);
}

TEST(Regions, CellsAddUpToTheirRegion) {
  const par::Comm world = par::Comm::world();
  const Cubic pack(world);
  auto region = box({0.02, 0.5}, {0.03, 0.44}, {0.04, 0.47});
  const observe::Measurement whole = observe::measure(world, pack.particles, region).at(0);
  region.cells = {3, 2, 5};
  const std::vector<observe::Measurement> cells = observe::measure(world, pack.particles, region);
  ASSERT_EQ(cells.size(), 30u);
  observe::Measurement mean;
  mean.porosity = 0;
  for (const observe::Measurement& c : cells) {
    mean.porosity += c.porosity / 30, mean.bulk_density += c.bulk_density / 30;
    mean.stones += c.stones, mean.contacts += c.contacts;
    for (std::size_t k = 0; k < 6; ++k) mean.stress[k] += c.stress[k] / 30;
  }
  EXPECT_NEAR(mean.porosity, whole.porosity, sum_rounding);
  EXPECT_NEAR(mean.bulk_density, whole.bulk_density, sum_rounding * whole.bulk_density);
  EXPECT_EQ(mean.stones, whole.stones);
  EXPECT_EQ(mean.contacts, whole.contacts);
  const double size = pack.stress().norm();
  for (std::size_t k = 0; k < 6; ++k)
    EXPECT_NEAR(mean.stress[k], whole.stress[k], sum_rounding * size);
}

// One contact and a sphere of radius s < r about its middle: 2 s of the branch are in it.
TEST(Regions, ASphereTakesItsPartOfABranch) {
  const par::Comm world = par::Comm::world();
  dem::Particles particles(world, test::one_material(springs(), density), {.gravity = 0},
                           test::box({-1, -1, -1}, {1, 1, 1}));
  particles.add_template(test::sphere());
  std::vector<dem::NewParticle> two(2);
  const Vec3 along = Vec3(1, 2, 3).normalized();
  constexpr double overlap = 1e-4, s = 0.03;
  for (std::size_t k = 0; k < 2; ++k) {
    two[k].id = static_cast<Id>(k), two[k].scale = r;
    two[k].position = (k == 0 ? -1 : 1) * (r - overlap / 2) * along;
  }
  particles.add(test::mine(world, two));
  particles.advance(1e-12, 1);
  observe::Region region;
  region.kind = observe::RegionKind::sphere;
  region.centre = {0, 0, 0}, region.radius = s;
  const observe::Measurement m = observe::measure(world, particles, region).at(0);
  const double force = k_n * overlap, volume = 4.0 / 3 * pi * s * s * s;
  const double stress = force * 2 * s / volume;
  EXPECT_NEAR(m.stress[0], -stress * along.x() * along.x(), overlap_rounding * stress);
  EXPECT_NEAR(m.stress[5], -stress * along.y() * along.z(), overlap_rounding * stress);
  EXPECT_EQ(m.contacts, 1);
  EXPECT_NEAR(m.contact_force, force, overlap_rounding * force);
  EXPECT_NEAR(m.fabric[3], along.x() * along.y(), rounding);
}

// One sphere may contain a force chain or none; the mean over all positions in a cell of the
// lattice is the stress of the pack.
TEST(Regions, SpheresHaveTheMeanStress) {
  const par::Comm world = par::Comm::world();
  const Cubic pack(world);
  observe::Region region;
  region.kind = observe::RegionKind::sphere;
  region.radius = 0.03;
  constexpr int n = 16;  // with 8 the sum over positions has an error of 3 %
  Vec3 mean = Vec3::Zero();
  for (int i = 0; i < n * n * n; ++i) {
    const Vec3 place(i % n + 0.5, i / n % n + 0.5, i / (n * n) + 0.5);
    const Vec3 centre = pack.d.cwiseProduct(Vec3(2, 2, 2) + place / n);
    region.centre = {centre.x(), centre.y(), centre.z()};
    const observe::Measurement m = observe::measure(world, pack.particles, region).at(0);
    mean += Vec3(m.stress[0], m.stress[1], m.stress[2]) / (n * n * n);
  }
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(mean[k] / pack.stress()[k], 1, 0.02);
}

// Irregular stones in contact: bitwise identical on any number of ranks.
TEST(Regions, AreBitwiseIdenticalOnAnyRanks) {
  const auto values = [](const par::Comm& comm) {
    dem::Domain domain = test::box({0, 0, -1}, {0.4, 0.32, 1});
    domain.periodic = {true, true, false};
    dem::Particles particles(comm, test::one_material(springs()), {}, domain);
    for (std::uint64_t k = 0; k < 3; ++k) particles.add_template(test::irregular(0.03, 0.002, k));
    auto all = test::lattice({8, 6, 5}, 0.052, 1, 3);
    for (auto& p : all) p.velocity *= 0.5;
    particles.add(test::mine(comm, all));
    for (int k = 0; k < 40; ++k) particles.advance(5e-4, 20);
    observe::Region region;
    region.x = {0.07, 0.47}, region.y = {0, 0.3}, region.z = {0, 0.2}, region.cells = {3, 2, 2};
    std::vector<double> list;
    for (const observe::Measurement& m : observe::measure(comm, particles, region)) {
      list.insert(list.end(), {m.porosity, m.bulk_density, m.stones, m.coordination, m.contacts,
                               m.contact_force, m.speed, m.speed_deviation, m.largest_speed,
                               m.stone_force, m.stone_force_deviation, m.largest_stone_force});
      list.insert(list.end(), m.stress.begin(), m.stress.end());
      list.insert(list.end(), m.fabric.begin(), m.fabric.end());
    }
    return list;
  };
  const std::vector<double> alone = values(par::Comm::self()), shared = values(par::Comm::world());
  EXPECT_EQ(alone, shared);
  double contacts = 0;
  for (std::size_t k = 4; k < alone.size(); k += 24) {
    contacts += alone[k];
    // Normals of corners, edges and faces alike have unit length.
    const double* fabric = &alone[k + 14];
    if (alone[k] > 0) {
      EXPECT_NEAR(fabric[0] + fabric[1] + fabric[2], 1, rounding);
    }
  }
  EXPECT_GT(contacts, 0);
}

// m^2 of a polygon (x, z) below the line z = cut: the trapezoids between its edges and that line.
double area_below(const std::vector<Eigen::Vector2d>& polygon, double cut) {
  double area = 0;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Eigen::Vector2d &a = polygon[k], &b = polygon[(k + 1) % polygon.size()];
    // The depth below the cut is linear along the edge; negative values count as 0.
    const double da = cut - a.y(), db = cut - b.y(), width = b.x() - a.x();
    if (da >= 0 && db >= 0)
      area += width * (da + db) / 2;
    else if (da > 0 || db > 0)
      area += width * std::max(da, db) / std::abs(da - db) * std::max(da, db) / 2;
  }
  return area;
}

// Volume fraction of the stone below z = cut, measured by regions. `volume`: of the stone, m^3.
double fraction_below(const par::Comm& comm, const dem::Particles& particles, double volume,
                      double cut) {
  const auto region = box({-0.1, 0.1}, {-0.1, 0.1}, {-0.1, cut});
  const dem::Domain& domain = particles.domain();
  const double across = domain.dimension == Dimension::plane ? domain.thickness : 0.2;
  const observe::Measurement m = observe::measure(comm, particles, region).at(0);
  EXPECT_NEAR(m.bulk_density, density * (1 - m.porosity), rounding * density);
  return (1 - m.porosity) * 0.2 * across * (cut + 0.1) / volume;
}

// One stone at the origin.
dem::Particles alone(const par::Comm& comm, const dem::Template& shape, const Quat& attitude,
                     Dimension dimension) {
  dem::Domain domain = test::box({-1, -1, -1}, {1, 1, 1});
  domain.dimension = dimension;
  if (dimension == Dimension::plane) domain.thickness = 0.7;
  dem::Particles particles(comm, test::one_material(springs(), density), {.gravity = 0}, domain);
  particles.add_template(shape);
  dem::NewParticle stone;
  stone.id = 0, stone.scale = 1, stone.attitude = attitude;
  particles.add(test::mine(comm, {stone}));
  return particles;
}

// A stone of pebbles is a ring of disks with the mass of the area that its outline encloses; so is
// each part of it, cut at any height in any attitude. The disks may leave gaps between them.
TEST(Regions, PebblesAreSolidWithin) {
  const par::Comm world = par::Comm::world();
  constexpr double size = 0.06, pebble = 0.006;  // m
  double worst = 0;
  for (std::uint64_t seed = 0; seed < 4; ++seed)
    for (const double spacing : {1.5, 3.0})
      for (const double turn : {0.0, 0.4, 1.9}) {
        auto outline = geom::outline({}, seed);
        for (auto& corner : outline) corner *= size;
        std::vector<geom::Piece> disks;
        for (const geom::Sphere& s : geom::pebbles_inside(outline, pebble, spacing))
          disks.push_back(geom::ball(s.centre, s.radius));
        const geom::Solid solid = geom::polygon_solid(outline);
        const Quat about_y(Eigen::AngleAxisd(turn, Vec3::UnitY()));
        const dem::Particles stone = alone(world, geom::template_of(disks, solid, size),
                                           about_y * solid.axes, Dimension::plane);
        for (auto& corner : outline) {
          const Vec3 at = about_y * Vec3(corner.x(), 0, corner.y());
          corner = {at.x(), at.z()};
        }
        for (double cut = -0.03; cut < 0.03; cut += 0.00171) {
          const double wanted = area_below(outline, cut) / solid.volume;
          worst = std::max(
              worst, std::abs(fraction_below(world, stone, solid.volume * 0.7, cut) - wanted));
        }
      }
  EXPECT_LT(worst, 0.01);  // accuracy of points_within for laminas
}

// Two stones that touch with two pieces each count once as partners.
TEST(Regions, PartnersWithTwoContactsCountOnce) {
  const par::Comm world = par::Comm::world();
  dem::Particles stones(world, test::one_material(springs(), density), {.gravity = 0},
                        test::box({-1, -1, -1}, {1, 1, 1}));
  stones.add_template(geom::template_of({geom::ball({-r, 0, 0}, r), geom::ball({r, 0, 0}, r)}));
  std::vector<dem::NewParticle> pair(3);  // the third one touches nothing
  pair[1].id = 1, pair[2].id = 2;
  pair[2].position = {0, 5 * r, 0};
  for (dem::NewParticle& stone : pair) stone.scale = 1;
  pair[1].position = {0, 0, 2 * r - 1e-4};
  pair[0].velocity = {0.3, 0, 0}, pair[1].velocity = {0, 0.1, 0};
  stones.add(test::mine(world, pair));
  stones.advance(1e-12, 1);
  const auto all = box({-0.5, 0.5}, {-0.5, 0.5}, {-0.5, 0.5});
  const observe::Measurement m = observe::measure(world, stones, all).at(0);
  EXPECT_EQ(m.contacts, 2);
  EXPECT_NEAR(m.coordination, 2.0 / 3, rounding);
  // 0.3, 0.1 and 0 m/s, changed by forces of 200 N in 1e-12 s by 1e-10 m/s.
  EXPECT_NEAR(m.speed, 0.4 / 3, 1e-9);
  EXPECT_NEAR(m.speed_deviation, std::sqrt(0.1 / 3 - 0.16 / 9), 1e-9);
  EXPECT_NEAR(m.largest_speed, 0.3, 1e-9);
  const double force = 2 * k_n * 1e-4;  // on each, of two contacts
  EXPECT_NEAR(m.stone_force, 2 * force / 3, 1e-6 * force);
  EXPECT_NEAR(m.stone_force_deviation, std::sqrt(2.0) / 3 * force, 1e-6 * force);
  EXPECT_NEAR(m.largest_stone_force, force, 1e-6 * force);
}

// The volume fraction of a spherical cap of height h = z + r: h^2 (3 r - h)/(4 r^3).
TEST(Regions, ABallIsCutAtItsPosition) {
  const par::Comm world = par::Comm::world();
  const dem::Particles ball = alone(world, test::sphere(r), Quat::Identity(), Dimension::space);
  const double volume = 4.0 / 3 * pi * r * r * r;
  for (double h = 0.001; h < 2 * r; h += 0.00171) {
    const double wanted = h * h * (3 * r - h) / (4 * r * r * r);
    EXPECT_NEAR(fraction_below(world, ball, volume, h - r), wanted, 0.03);  // points_within
  }
}

}  // namespace
}  // namespace trackbed::regions_test
