// A measured running surface from a file beside the deck.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "trackbed/core/error.hpp"
#include "trackbed/track/irregularity.hpp"

namespace trackbed::track {
namespace {

IrregularityParameters from(const std::string& name, const std::string& rows) {
  IrregularityParameters p;
  p.kind = IrregularityKind::file;
  p.fade = 0;
  p.file = name;
  std::ofstream(p.file) << "x_m,z_m\n" << rows;
  return p;
}

// Rows every 0.5 m of a straight slope and a level end: the cubic through them is the slope.
TEST(ProfileFile, FollowsItsRows) {
  std::string rows;
  for (int i = 0; i <= 40; ++i) rows += fmt::format("{},{}\n", 0.5 * i, i <= 20 ? 1e-4 * i : 2e-3);
  const IrregularityParameters p = from("trackbed_profile.csv", rows);
  const Irregularity profile(p, 20);
  EXPECT_NEAR(profile.at(3), 0.6e-3, 1e-15);
  EXPECT_NEAR(profile.at(3.2), 0.64e-3, 1e-15);
  EXPECT_NEAR(profile.at(15.3), 2e-3, 1e-15);
  EXPECT_EQ(profile.at(-1), 0);
  EXPECT_NEAR(profile.at(25), 2e-3, 1e-9);
  std::filesystem::remove(p.file);
}

// It fades in from nothing over `fade`, so that the train does not begin on a step.
TEST(ProfileFile, FadesIn) {
  IrregularityParameters p = from("trackbed_level.csv", "0,1e-3\n10,1e-3\n20,1e-3\n");
  p.fade = 4;
  const Irregularity profile(p, 20);
  EXPECT_NEAR(profile.at(1e-9), 0, 1e-12);
  EXPECT_NEAR(profile.at(2), 0.5e-3, 1e-12);
  EXPECT_NEAR(profile.at(4), 1e-3, 1e-12);
  std::filesystem::remove(p.file);
}

TEST(ProfileFile, OneRowIsNoProfile) {
  const IrregularityParameters p = from("trackbed_row.csv", "0,1e-3\n");
  EXPECT_THROW(Irregularity(p, 20), InputError);
  std::filesystem::remove(p.file);
}

}  // namespace
}  // namespace trackbed::track
