// The deck section [ground]: values read, and messages of refusals.
#include <gtest/gtest.h>

#include <fstream>

#include "trackbed/core/error.hpp"
#include "trackbed/fem/ground.hpp"
#include "trackbed/input/deck.hpp"

namespace trackbed::fem::ground_deck_test {
namespace {

GroundParameters read(const std::string& text) {
  GroundParameters p;
  input::Deck::parse(text, "deck.toml").fill([&](input::Section& s) {
    s.table("ground", p, "The ground.");
  });
  return p;
}

// All problems of a deck, one per line; empty if it is accepted.
std::string problems(const std::string& text) {
  try {
    read(text);
  } catch (const InputError& error) {
    std::string all;
    for (const auto& problem : error.problems()) all += problem + "\n";
    return all;
  }
  return "";
}

constexpr const char* good = R"([ground]
x = [0, 17]
elements_x = 300
elements_z = 100
base = "viscous"
sides = "viscous"
plane = "strain"
integrator = "newmark"
[[ground.layer]]
name = "surface"
thickness = 0.6
young = 180e6
[[ground.layer]]
name = "subgrade"
thickness = 5.0
poisson = 0.4
[[ground.block]]
name = "wedge"
outline = [2, 0, 15, 0, 5, -5, 2, -5]
young = 1e9
)";

TEST(GroundDeck, IsRead) {
  const GroundParameters p = read(good);
  EXPECT_EQ(p.elements_x, 300);
  EXPECT_EQ(p.base, Base::viscous);
  EXPECT_EQ(p.sides, Sides::viscous);
  EXPECT_EQ(p.plane, PlaneState::strain);
  EXPECT_EQ(p.integrator, Integrator::newmark);
  ASSERT_EQ(p.layers.size(), 2u);
  EXPECT_EQ(p.layers[0].solid.young, 180e6);
  EXPECT_EQ(p.layers[1].solid.poisson, 0.4);
  ASSERT_EQ(p.blocks.size(), 1u);
  EXPECT_EQ(p.blocks[0].outline.size(), 8u);
}

TEST(GroundDeck, RefusesInvalidValues) {
  const std::string text = good;
  EXPECT_EQ(problems(text), "");
  std::string softer_than_nothing = text;
  softer_than_nothing.replace(text.find("young = 1e9"), 11, "young = -1");
  EXPECT_NE(problems(softer_than_nothing).find("ground.block[0].young = -1 must be above 0"),
            std::string::npos)
      << problems(softer_than_nothing);
  const auto with = [&](const std::string& line) {
    return problems("[ground]\n" + line + "\n[[ground.layer]]\nthickness = 1\n");
  };
  EXPECT_EQ(with("elements_z = 3"), "");
  EXPECT_NE(with("elements_z = 0").find("elements_z"), std::string::npos);
  EXPECT_NE(with("x = [3, 1]").find("must be two increasing numbers"), std::string::npos);
  EXPECT_NE(with("x = [3]"), "");
  EXPECT_NE(with("safety = 1.2").find("safety"), std::string::npos);
  EXPECT_NE(with("newmark_gamma = 0.9").find("half of newmark_gamma"), std::string::npos);
  EXPECT_EQ(with("integrator = \"bossak\"\nalpha = -0.5"), "");
  EXPECT_NE(with("integrator = \"hht\"\nalpha = -0.5").find("at least -1/3 for hht"),
            std::string::npos);
  EXPECT_NE(with("alpha = 0.1").find("alpha"), std::string::npos);
  EXPECT_NE(with("rho_inf = 1.1").find("rho_inf"), std::string::npos);
  EXPECT_NE(with("base = \"soft\"").find("base"), std::string::npos);
  EXPECT_NE(problems("[ground]\n").find("the ground is empty"), std::string::npos);
  EXPECT_NE(with("[[ground.block]]\noutline = [0, 0, 1, 1]").find("at least 3 corners"),
            std::string::npos);
}

// The file itself is checked when the ground is built.
TEST(GroundDeck, AMeshReplacesLayers) {
  std::ofstream("any.msh") << "$MeshFormat";
  const std::string head = "[ground]\nmesh = \"any.msh\"\n";
  const std::string groups =
      "[[ground.solid]]\nname = \"clay\"\nyoung = 20e6\n[[ground.border]]\nname = \"bottom\"\n"
      "holds = \"viscous\"\n";
  const GroundParameters p = read(head + "mesh_top = \"crest\"\n" + groups);
  EXPECT_TRUE(p.mesh.ends_with("any.msh"));
  EXPECT_EQ(p.mesh_top, "crest");
  ASSERT_EQ(p.solids.size(), 1u);
  EXPECT_EQ(p.solids[0].solid.young, 20e6);
  ASSERT_EQ(p.borders.size(), 1u);
  EXPECT_EQ(p.borders[0].holds, BorderKind::viscous);
  const auto refused = [&](const std::string& text, const std::string& words) {
    EXPECT_NE(problems(text).find(words), std::string::npos) << problems(text);
  };
  refused(head + "elements_x = 3\n" + groups, "elements_x = 3: has no effect with ground.mesh");
  refused(head + "sides = \"viscous\"\n" + groups,
          "describe the surfaces of the mesh by [[ground.border]]");
  refused(head + groups + "[[ground.layer]]\nthickness = 1\n",
          "describe the volumes of the mesh by [[ground.solid]]");
  refused(head + groups + groups, "is already the name of another part of the mesh");
  refused(head + groups + "[[ground.border]]\nname = \"top\"\n",
          "is already the name of another part of the mesh");
  refused(head + "[[ground.solid]]\nname = \"clay\"\n", "must hold the ground somewhere");
  refused("[ground]\nmesh = \"none.msh\"\n" + groups, "does not exist");
  refused("[ground]\nmesh_top = \"crest\"\n[[ground.layer]]\nthickness = 1\n",
          "has no effect without mesh");
}

// A layer without the centre of an element would have no effect.
TEST(GroundDeck, LayersHaveElements) {
  const auto with = [](const std::string& found, const std::string& put) {
    std::string text = good;
    return problems(text.replace(text.find(found), found.size(), put));
  };
  EXPECT_NE(with("thickness = 0.6", "thickness = 0.02")
                .find("does not contain the centre of any element"),
            std::string::npos);
  EXPECT_EQ(with("thickness = 0.6", "thickness = 0.06"), "");
  EXPECT_NE(
      with("thickness = 0.6", "thickness = 0.6\nelements = 8").find("must all have `elements`"),
      std::string::npos);
}

}  // namespace
}  // namespace trackbed::fem::ground_deck_test
