// An embankment of sections: its mesh, the boundary conditions of its sides, and its motion as a
// ground of tetrahedra on any number of ranks.
#include "fem/mesh/embankment.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "fem/shape/tetrahedron.hpp"
#include "trackbed/io/file.hpp"
#include "unit/fem/embankment_scene.hpp"
#include "unit/fem/pushed_top.hpp"

namespace trackbed::fem::embankment_test {
namespace {

using par::Comm;

// Crest, height and slope change along the track.
GroundParameters changing() {
  GroundParameters p = embankment();
  p.sections = {{.x = 0, .crest = 3, .height = 2, .slope = 1.5},
                {.x = 2, .crest = 3, .height = 2, .slope = 1.5},
                {.x = 6, .crest = 4.5, .height = 1.6, .slope = 1.5}};
  return p;
}

// Volume below the top, m^3: with one slope the sides are plane, and the prismatoid rule (ends and
// four times the middle) is exact between two sections.
double volume_of(const GroundParameters& p, double depth) {
  const auto area = [&](double x) {
    const CrossSection s = p.section_at(x);
    const double beside = (p.y[1] - p.y[0]) * (depth - s.height);
    return s.height * (2 * s.crest + s.slope * s.height) + beside;
  };
  std::vector<double> ends = {p.x[0], p.x[1]};
  for (const CrossSection& s : p.sections)
    if (s.x > p.x[0] && s.x < p.x[1]) ends.insert(ends.end() - 1, s.x);
  double sum = 0;
  for (std::size_t i = 1; i < ends.size(); ++i)
    sum += (ends[i] - ends[i - 1]) / 6 *
           (area(ends[i - 1]) + 4 * area((ends[i - 1] + ends[i]) / 2) + area(ends[i]));
  return sum;
}

TEST(Embankment, HasTheVolumeOfItsSections) {
  for (const GroundParameters& p : {embankment(), changing()}) {
    const MeshReport report = look_at_mesh(p);
    EXPECT_NEAR(report.volume, volume_of(p, 4), 1e-10 * report.volume);
    EXPECT_TRUE(report.warnings.empty());
    EXPECT_EQ(report.low, Vec3(0, -10, -4));
    EXPECT_EQ(report.high, Vec3(6, 10, 0));
    const double widest = p.section_at(6).crest;
    EXPECT_NEAR(report.top_high.y(), widest, 1e-12);
    EXPECT_NEAR(report.top_low.y(), -widest, 1e-12);
  }
  GroundParameters half = changing();
  half.y = {0, 10}, half.elements_y = 5;
  EXPECT_NEAR(look_at_mesh(half).volume, volume_of(changing(), 4) / 2, 1e-9);
}

// As a mesh file it would pass all checks: elements are connected, none is inverted, and its
// borders are outside. Also where height and slope change together: intermediate slopes would bend
// it outwards.
TEST(Embankment, HasAStraightFoot) {
  GroundParameters p = embankment();
  p.y = {-7.5, 7.5};
  p.sections = {{.x = 0, .crest = 2, .height = 2.5, .slope = 2},
                {.x = 6, .crest = 4, .height = 1.5, .slope = 2}};
  for (const double x : {0.0, 1.0, 3.0, 6.0}) EXPECT_NEAR(p.section_at(x).foot(), 7, 1e-12) << x;
  const MeshReport report = look_at_mesh(p);
  EXPECT_EQ(report.high.y(), 7.5);
  // Widths and heights are both linear, so the volume is quadratic in x.
  const auto area = [&](double x) {
    const CrossSection s = p.section_at(x);
    return s.height * (s.crest + s.foot()) + 15 * (4 - s.height);
  };
  EXPECT_NEAR(report.volume, 6.0 / 6 * (area(0) + 4 * area(3) + area(6)), 0.01 * report.volume);
}

TEST(Embankment, HasACrestWithinFewColumns) {
  GroundParameters p = embankment();
  p.y = {-100, 10}, p.elements_y = 3;
  const MeshReport report = look_at_mesh(p);
  EXPECT_NEAR(report.top_high.y() - report.top_low.y(), 6, 1e-12);
  EXPECT_NEAR(report.volume, volume_of(p, 4), 1e-10 * report.volume);
}

TEST(Embankment, IsAValidMeshFile) {
  for (const GroundParameters& p : {embankment(), changing(), upright({-3, 3})}) {
    const SolidMesh mesh = embankment_mesh(p);
    GmshFile file;
    file.path = "sections";
    file.groups = {{3, 1, "soil"}, {2, 1, "top"}, {2, 2, "fixed"}, {2, 3, "roller"}};
    for (std::size_t n = 0; n < mesh.position.size(); ++n)
      file.nodes.push_back({static_cast<Id>(n + 1), mesh.position[n], n});
    for (const auto& nodes : mesh.element)
      file.tetrahedra.push_back({static_cast<Id>(file.tetrahedra.size() + 1), 1, 0, nodes});
    const auto add = [&](const std::vector<SolidMesh::Face>& faces) {
      for (const SolidMesh::Face& face : faces) {
        GmshFile::Element triangle{1,
                                   1,
                                   face.holds == BorderKind::free    ? 1
                                   : face.holds == BorderKind::fixed ? 2
                                                                     : 3,
                                   {}};
        const auto nodes = mesh.nodes_of(face);
        std::copy(nodes.begin(), nodes.end(), triangle.nodes.begin());
        file.triangles.push_back(triangle);
      }
    };
    add(mesh.top), add(mesh.borders);
    GroundParameters of;
    of.solids = {{"soil", {}}};
    of.borders = {{"fixed", BorderKind::fixed}, {"roller", BorderKind::roller}};
    const SolidMesh read = solid_mesh_of(of, file);  // throws on any error
    ASSERT_EQ(read.borders.size(), mesh.borders.size());
    for (std::size_t f = 0; f < mesh.borders.size(); ++f) {
      const SolidMesh::Face &one = read.borders[f], &other = mesh.borders[f];
      EXPECT_EQ(one.element, other.element);
      EXPECT_EQ(one.side, other.side);
      EXPECT_EQ(one.axis, other.axis);
      EXPECT_EQ(one.low, other.low);
    }
    EXPECT_EQ(read.top.size(), mesh.top.size());
    // Free faces are slopes and natural ground; a box has none.
    EXPECT_EQ(read.open.empty(), p.sections.front().slope == 0);
  }
}

// Each side has the condition of the deck; viscous sides are dashpots of the impedances of their
// directions (Lysmer, Kuhlemeyer 1969), without constraints.
TEST(Embankment, HasTheBoundaryConditionsOfTheDeck) {
  GroundParameters p = upright({-3, 3});
  const Elastic soil{50e6, 0.3, 2000};
  for (Layer& layer : p.layers) layer.solid = soil;
  const std::array<BorderKind, 4> kinds = {BorderKind::roller, BorderKind::viscous,
                                           BorderKind::free, BorderKind::fixed};
  const std::array<Sides, 4> sides = {Sides::roller, Sides::viscous, Sides::free, Sides::fixed};
  const double modulus = 50e6 * 0.7 / (1.3 * 0.4), shear = 50e6 / 2.6;  // Pa
  for (std::size_t turn = 0; turn < 4; ++turn) {
    const auto at = [&](std::size_t side) { return (side + turn) % 4; };
    p.side_x_low = sides[at(0)], p.side_x_high = sides[at(1)];
    p.side_y_low = sides[at(2)], p.side_y_high = sides[at(3)];
    p.base = turn % 2 == 0 ? Base::fixed : Base::viscous;
    std::array<double, 3> viscous{};  // N s/m, along the axes
    for (const SolidMesh::Face& face : embankment_mesh(p).borders) {
      const auto side = static_cast<std::size_t>(2 * face.axis + (face.low ? 0 : 1));
      const BorderKind base = turn % 2 == 0 ? BorderKind::fixed : BorderKind::viscous;
      EXPECT_EQ(face.holds, side == 4 ? base : kinds[at(side)]) << turn << ' ' << side;
    }
    for (std::size_t side = 0; side < 5; ++side) {
      if (side == 4 ? turn % 2 == 0 : kinds[at(side)] != BorderKind::viscous) continue;
      const double area = Vec3(6 * 4, 6 * 4, 6 * 6)[side / 2];  // m^2
      for (std::size_t c = 0; c < 3; ++c)
        viscous[c] += area * std::sqrt(soil.density * (c == side / 2 ? modulus : shear));
    }
    const Mesh mesh(Comm::self(), p, Dimension::space, 1);
    const Terms terms(mesh, p, Stiffness(mesh, {}));
    for (int c = 0; c < 3; ++c) {
      double sum = 0;
      for (std::size_t n = 0; n < mesh.nodes(); ++n) sum += terms.damping[c][n];
      const double exact = viscous[static_cast<std::size_t>(c)];
      EXPECT_NEAR(sum, exact, 1e-9 * exact) << turn << ' ' << c;
    }
    // Viscous sides move, others according to their kind.
    for (std::size_t n = 0; n < mesh.nodes(); ++n) {
      const Vec3 x = mesh.position(static_cast<std::int32_t>(n));
      const std::array<bool, 5> on = {x.x() < 1e-9, x.x() > 6 - 1e-9, x.y() < -3 + 1e-9,
                                      x.y() > 3 - 1e-9, x.z() < -4 + 1e-9};
      int held = 0;
      for (std::size_t side = 0; side < 5; ++side) {
        if (!on[side]) continue;
        const BorderKind kind = side < 4        ? kinds[at(side)]
                                : turn % 2 == 0 ? BorderKind::fixed
                                                : BorderKind::viscous;
        if (kind == BorderKind::fixed) held |= 7;
        if (kind == BorderKind::roller) held |= 1 << (side / 2);
      }
      EXPECT_EQ(terms.held[n], held) << turn << ' ' << x.transpose();
    }
  }
}

TEST(Embankment, HasLayersAndBlocksInPlace) {
  GroundParameters p = changing();
  p.blocks = {{.name = "wedge", .outline = {0, 0, 2, 0, 2, -4, 0, -4}, .solid = {1e9, 0.2, 2200}}};
  const SolidMesh mesh = embankment_mesh(p);
  std::array<double, 4> volume{};
  for (std::size_t e = 0; e < mesh.element.size(); ++e) {
    TenNodes nodes;
    for (std::size_t k = 0; k < 10; ++k)
      nodes[k] = mesh.position[static_cast<std::size_t>(mesh.element[e][k])];
    volume[static_cast<std::size_t>(mesh.solid[e])] += tetrahedron_volume(nodes);
  }
  // The first 2 m are uniform: the block has the whole section.
  EXPECT_NEAR(volume[3], 2 * (2 * (6 + 3) + 20 * 2), 1e-9);
  // The capping layer keeps its metre, the fill is thinner where the height is smaller: its foot is
  // at 3 + 1.5 * 2 = 6 and 4.5 + 1.5 * 1.6 = 6.9 m.
  const auto capping = [](double crest) { return 2 * crest + 1.5; };
  EXPECT_NEAR(volume[0], 4 * (capping(3) + capping(4.5)) / 2, 1e-9);
  EXPECT_NEAR(volume[0] + volume[1] + volume[2] + volume[3], look_at_mesh(p).volume, 1e-9);
  EXPECT_LT(volume[1], 4 * 2 * (6 + 4.5) / 2 * 1.01);
}

TEST(Embankment, IsSymmetricAndMovesSymmetrically) {
  const GroundParameters p = changing();
  const SolidMesh mesh = embankment_mesh(p);
  double far = 0;  // m, distance of an image from the nearest node
  for (const Vec3& at : mesh.position) {
    double least = 1;
    for (const Vec3& other : mesh.position)
      least = std::min(least, (other - Vec3(at.x(), -at.y(), at.z())).norm());
    far = std::max(far, least);
  }
  EXPECT_LT(far, 1e-12);
  const Rest rest(p);
  for (const Vec3& place : {Vec3(2, 3, 0), Vec3(4, 6, -2), Vec3(0, 1.2, -1), Vec3(6, 10, -2)}) {
    const Vec3 one = rest.at(place), other = rest.at({place.x(), -place.y(), place.z()});
    EXPECT_NEAR(one.z(), other.z(), 1e-8 * std::abs(one.z()));
    EXPECT_NEAR(one.y(), -other.y(), 1e-8 * std::abs(one.z()));
    EXPECT_NEAR(one.x(), other.x(), 1e-8 * std::abs(one.z()));
  }
}

// With rollers along the axis half of it moves as the whole.
TEST(Embankment, HalfWithRollersMovesAsTheWhole) {
  GroundParameters half = changing();
  half.y = {0, 10}, half.elements_y = 5;
  const Rest whole(changing()), one_side(half);
  for (const Vec3& place : {Vec3(2, 3, 0), Vec3(4, 0, 0), Vec3(6, 10, -2)})
    EXPECT_LT((whole.at(place) - one_side.at(place)).norm(), 1e-8 * whole.at(place).norm());
}

TEST(Embankment, SettlesLessAboveAWedge) {
  GroundParameters p = embankment();
  const double without = Rest(p).at({0, 0, 0}).z();
  p.blocks = {{.name = "wedge", .outline = {0, 0, 4, 0, 0, -3}, .solid = {5e9, 0.2, 2000}}};
  const double with = Rest(p).at({0, 0, 0}).z();
  EXPECT_LT(without, 0);
  EXPECT_LT(std::abs(with), 0.9 * std::abs(without));
  p.blocks.front().present = false;
  EXPECT_NEAR(Rest(p).at({0, 0, 0}).z(), without, 1e-9 * std::abs(without));
}

TEST(Embankment, HasTheModulusOfATableAlongTheTrack) {
  GroundParameters p = embankment();
  const double before = Rest(p).at({6, 0, 0}).z();
  p.layers[0].young_file = fmt::format("embankment_young_{}.csv", Comm::world().size());
  if (Comm::world().root())
    std::ofstream(p.layers[0].young_file) << "x_m,young_Pa\n0,120e6\n6,12e6\n";
  Comm::world().sum(1.0);  // no rank reads before the file is written
  EXPECT_LT(Rest(p).at({6, 0, 0}).z(), 1.02 * before);
}

TEST(Embankment, IsBitwiseIdenticalOnAnyNumberOfRanksAndAfterAStop) {
  GroundParameters p = changing();
  p.base = Base::viscous, p.sides = Sides::viscous, p.rayleigh_mass = 2;
  const Comm world = Comm::world();
  Ground alone(Comm::self(), p, Dimension::space, 1), shared(world, p, Dimension::space, 1);
  Ground second(world, p, Dimension::space, 1);
  std::string by_one, by_all;
  EXPECT_EQ(alone.stable_step(&by_one), shared.stable_step(&by_all));
  EXPECT_EQ(by_one, by_all);
  EXPECT_TRUE(by_one.starts_with("a tetrahedron at x = ")) << by_one;
  const double dt = 2.5 * shared.stable_step();
  for (Ground* ground : {&alone, &shared}) {
    ground->settle(uneven_load(ground->top(), 0));
    for (int w = 1; w < 10; ++w) ground->advance(dt, uneven_load(ground->top(), w));
  }
  const std::string path = fmt::format("embankment_on_{}.h5", world.size());
  {
    io::File file(world, path, io::Mode::create);
    shared.save(file, "ground");
  }
  {
    const io::File file(world, path, io::Mode::read);
    second.load(file, "ground");
  }
  for (Ground* ground : {&alone, &shared, &second})
    for (int w = 10; w < 15; ++w) ground->advance(dt, uneven_load(ground->top(), w));
  const std::vector<double> one = shape_of(Comm::self(), alone);
  EXPECT_EQ(one, shape_of(world, shared));
  EXPECT_EQ(one, shape_of(world, second));
  EXPECT_GT(*std::max_element(one.begin(), one.end()), 1e-9);
}

}  // namespace
}  // namespace trackbed::fem::embankment_test
