// Mesh files: valid files, messages of refusals, and robustness against arbitrary bytes.
#include "fem/mesh/gmsh.hpp"

#include <gtest/gtest.h>

#include "fem/mesh/solid_mesh.hpp"
#include "trackbed/core/error.hpp"
#include "unit/fem/mesh_scene.hpp"

namespace trackbed::fem::gmsh_test {
namespace {

const TetBox& box() {
  static const TetBox made({2, 1, 1}, {2, 1, 1});
  return made;
}

GroundParameters parameters() {
  GroundParameters p;
  p.mesh = "box.msh";
  p.solids = {{"soil", {50e6, 0.3, 2000}}};
  for (std::size_t s = 0; s < 5; ++s) p.borders.push_back({TetBox::sides[s], BorderKind::roller});
  p.borders[4].holds = BorderKind::fixed;
  return p;
}

// All messages on a text, one per line; empty if it is a valid ground.
std::string problems(const std::string& text, const GroundParameters& p = parameters()) {
  try {
    solid_mesh_of(p, parse_gmsh(text, "box.msh"));
  } catch (const InputError& error) {
    std::string all;
    for (const auto& problem : error.problems()) all += problem + "\n";
    return all;
  }
  return "";
}

std::string with(std::string text, const std::string& what, const std::string& instead) {
  const auto at = text.find(what);
  EXPECT_NE(at, text.npos) << what;
  return at == text.npos ? text : text.replace(at, what.size(), instead);
}

TEST(Gmsh, BothFormatsAreTheSameGround) {
  const SolidMesh four = solid_mesh_of(parameters(), parse_gmsh(box().text_4(), "box.msh"));
  const SolidMesh two = solid_mesh_of(parameters(), parse_gmsh(box().text_2(), "box.msh"));
  ASSERT_EQ(four.element.size(), 12u);
  EXPECT_EQ(four.position.size(), 45u);
  EXPECT_EQ(four.element, two.element);
  EXPECT_EQ(four.position, two.position);
  EXPECT_EQ(four.top.size(), 4u);
  EXPECT_EQ(four.borders.size(), 4u + 2 * 2 + 2 * 4);
  EXPECT_EQ(two.borders.size(), four.borders.size());
  EXPECT_EQ(four.depth(), 1);
}

// Line ends of Windows, comments between sections, a solid without a name.
TEST(Gmsh, UnusualFilesAreRead) {
  std::string text = "$Comments\nmade by hand $Nodes\n$EndComments\n";
  for (const char c : box().text_4()) text += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(problems(text), "");
  const std::string nameless =
      with(with(box().text_2(), "3 1 \"soil\"\n", ""), "$PhysicalNames\n7", "$PhysicalNames\n6");
  GroundParameters p = parameters();
  p.solids[0].name = "1";
  EXPECT_EQ(problems(nameless, p), "");
}

std::string with_all(std::string text, const std::string& what, const std::string& instead) {
  EXPECT_NE(text.find(what), text.npos) << what;
  for (std::size_t at = 0; (at = text.find(what, at)) != text.npos; at += instead.size())
    text.replace(at, what.size(), instead);
  return text;
}

// Gmsh marks a reversed entity by a minus before the number of its group: the same ground.
TEST(Gmsh, ReversedEntitiesAreInTheirGroups) {
  const SolidMesh plain = solid_mesh_of(parameters(), parse_gmsh(box().text_4(), "box.msh"));
  std::string four = box().text_4(), two = box().text_2();
  for (const char* s : {"1", "5", "6"}) {
    const std::string place = fmt::format("\n{} 0 0 0 1 1 1 1 ", s);
    four = with(four, fmt::format("{}{} 0\n", place, s), fmt::format("{}-{} 0\n", place, s));
    two = with_all(two, fmt::format(" 9 2 {} ", s), fmt::format(" 9 2 -{} ", s));
  }
  four = with(four, "1 0 0 0 1 1 1 1 1 2 1 -2", "1 0 0 0 1 1 1 1 -1 2 1 -2");
  two = with_all(two, " 11 2 1 ", " 11 2 -1 ");
  for (const std::string& text : {four, two}) {
    ASSERT_EQ(problems(text), "");
    const SolidMesh found = solid_mesh_of(parameters(), parse_gmsh(text, "box.msh"));
    EXPECT_EQ(found.element, plain.element);
    EXPECT_EQ(found.solid, plain.solid);
    EXPECT_EQ(found.top.size(), plain.top.size());
    ASSERT_EQ(found.borders.size(), plain.borders.size());
    for (std::size_t b = 0; b < plain.borders.size(); ++b) {
      EXPECT_EQ(found.borders[b].element, plain.borders[b].element);
      EXPECT_EQ(found.borders[b].holds, plain.borders[b].holds);
    }
  }
}

struct Damage {
  std::string text, wanted;
};
class Damaged : public ::testing::TestWithParam<Damage> {};

TEST_P(Damaged, IsRefusedWithAMessage) {
  const std::string found = problems(GetParam().text);
  EXPECT_TRUE(found.starts_with("box.msh:")) << found;
  EXPECT_NE(found.find(GetParam().wanted), found.npos) << found;
}

TetBox turned() {
  TetBox odd = box();
  std::swap(odd.tetrahedron[3][0], odd.tetrahedron[3][1]);
  return odd;
}
TetBox in_two() {  // elements of the second cell get separate nodes where the first one has some
  TetBox odd = box();
  for (std::size_t e = 6; e < 12; ++e)
    for (int& n : odd.tetrahedron[e])
      if (std::abs(odd.node[static_cast<std::size_t>(n)].x() - 1) < 1e-9) {
        odd.node.push_back(odd.node[static_cast<std::size_t>(n)]);
        n = static_cast<int>(odd.node.size()) - 1;
      }
  return odd;
}
TetBox loose() {
  TetBox odd = box();
  odd.node.emplace_back(0.3, 0.3, -0.3);
  return odd;
}
TetBox sunken() {
  TetBox odd = box();
  for (Vec3& x : odd.node) x.z() -= 0.25;
  return odd;
}
TetBox leaning() {
  return {
      {2, 1, 1}, {2, 1, 1}, [](const Vec3& x) { return Vec3(x.x() + 0.3 * x.z(), x.y(), x.z()); }};
}
TetBox inner() {
  TetBox odd = box();
  const auto& t = odd.tetrahedron[0];
  odd.face.push_back({{t[1], t[2], t[3], t[5], t[8], t[9]}, 0});
  odd.face.push_back({{t[0], t[2], t[1], t[6], t[5], t[4]}, 0});
  odd.face.push_back({{t[0], t[1], t[3], t[4], t[9], t[7]}, 0});
  odd.face.push_back({{t[0], t[3], t[2], t[7], t[8], t[6]}, 0});
  return odd;
}

std::vector<Damage> damages() {
  const std::string four = box().text_4(), two = box().text_2();
  return {
      {with(four, "4.1 0 8", "4.0 0 8"), "box.msh:2: format 4.0 is not supported"},
      {with(four, "4.1 0 8", "4.1 1 8"), "box.msh:2: the file is binary"},
      {"solid cube\nfacet", "box.msh:1: a section such as $Nodes is expected here"},
      {"\n", "has no $MeshFormat"},
      {four.substr(0, four.find("$Elements")), "has no $Elements"},
      {four.substr(0, four.size() / 2), "ends too early; is it complete?"},
      {with(four, "$EndNodes", "$EndNode"), "found where $EndNodes is expected"},
      {with(two, "$Nodes\n45", "$Nodes\n4500000"), "more than the remaining file can contain"},
      {with(two, "\n2 0.5 0 -1", "\n1 0.5 0 -1"), "node 1 is given twice"},
      {with(two, "\n2 0.5 0 -1", "\n2 nan 0 -1"),
       "\"nan\" was found where a coordinate is expected"},
      {with(two, "\n45 2 1 0", "\n46 2 1 0"), "which is not in $Nodes"},
      {with(two, "\n21 11 2", "\n21 99 2"), "99 is not a known element type"},
      {with(two, "\n21 11 2 1 1", "\n21 11 2 0 1"), "element 21 is in no physical volume"},
      {with(four, "1 0 0 0 1 1 1 1 1 2 1 -2", "1 0 0 0 1 1 1 2 1 1 2 1 -2"),
       "is in more than one physical volume (and 11 more)"},
      {with(two, "\"soil\"", "\"soul\""),
       "\"soul\" has no [[ground.solid]] of that name; did you "},
      {with(two, "\"soil\"", "\"soul\""), "has no physical volume \"soil\", which the deck names"},
      {with(two, "\"y0\"", "\"why\""), "\"why\" has no [[ground.border]] of that name"},
      {with(two, "\"top\"", "\"lid\""), "has no physical surface \"top\", which the deck names"},
      {turned().text_4(), "is inverted or flat"},
      {in_two().text_2(), "but not connected with it: the ground has a gap there"},
      {in_two().text_2(), "is not connected with element"},
      {loose().text_4(), "node 46 is in no tetrahedron"},
      {sunken().text_4(), "the top must be at z = 0"},
      {leaning().text_4(), "of border \"x0\" is not normal to x, y or z"},
      {inner().text_4(), "is a triangle between two elements"},
      {inner().text_4(), "is a triangle identical to an earlier one"},
  };
}
INSTANTIATE_TEST_SUITE_P(, Damaged, ::testing::ValuesIn(damages()));

// One message for each kind of element, not for each element.
TEST(Gmsh, LinearTetrahedraAreRefused) {
  const std::string linear =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 -1\n"
      "5 1 1 -1\n$EndNodes\n$Elements\n3\n1 2 2 1 1 1 2 3\n2 4 2 1 1 1 3 2 4\n3 4 2 1 1 2 3 5 4\n"
      "$EndElements\n";
  const std::string found = problems(linear);
  EXPECT_NE(found.find("box.msh:14: element 1 is of type 3-node triangle"), found.npos) << found;
  EXPECT_NE(
      found.find("box.msh:15: element 2 is of type 4-node tetrahedron (the first of 2): linear "
                 "tetrahedra lock"),
      found.npos)
      << found;
  EXPECT_EQ(std::count(found.begin(), found.end(), '\n'), 2);
}

TEST(Gmsh, AMissingFileIsReported) { EXPECT_THROW(read_gmsh("no_such_file.msh"), InputError); }

// Truncated anywhere, or with any byte changed: a ground or a message that names the file.
TEST(Gmsh, FuzzedFilesAreGroundsOrErrors) {
  std::uint64_t seed = 1;
  const auto next = [&](std::size_t below) {
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<std::size_t>(seed >> 33) % below;
  };
  int refused = 0;
  const auto look = [&](const std::string& text) {
    const std::string found = problems(text);
    refused += found.empty() ? 0 : 1;
    if (!found.empty()) {
      EXPECT_TRUE(found.starts_with("box.msh:")) << found;
    }
  };
  for (const std::string& whole : {box().text_4(), box().text_2()}) {
    for (std::size_t end = 0; end < whole.size(); end += 1 + next(9)) look(whole.substr(0, end));
    for (int trial = 0; trial < 1500; ++trial) {
      std::string text = whole;
      for (std::size_t flips = 1 + next(4); flips > 0; --flips)
        text[next(text.size())] = static_cast<char>(trial % 2 == 0 ? next(256) : '0' + next(10));
      look(text);
    }
    for (int trial = 0; trial < 300; ++trial) {  // parts omitted or repeated
      const std::size_t from = next(whole.size()), length = next(60);
      look(whole.substr(0, from) + whole.substr(std::min(whole.size(), from + length)));
      look(whole.substr(0, from) + whole.substr(from > length ? from - length : 0));
    }
  }
  EXPECT_GT(refused, 3000);
}

}  // namespace
}  // namespace trackbed::fem::gmsh_test
