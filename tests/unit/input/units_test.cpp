// Values with a unit in the unit of a parameter.
#include "input/units.hpp"

#include <gtest/gtest.h>

namespace trackbed::input::units_test {
namespace {

TEST(Units, AreConverted) {
  EXPECT_EQ(in_unit("120 km/h", "m/s"), 120 * 10.0 / 36);
  EXPECT_EQ(in_unit("200MPa", "Pa"), 200e6);
  EXPECT_EQ(in_unit(" 5 mm ", "m"), 5e-3);
  EXPECT_EQ(in_unit("-1.5e2 kN", "N"), -150e3);
  EXPECT_EQ(in_unit("+60 kN/mm", "N/m"), 60e6);
  EXPECT_EQ(in_unit("2.6 t/m^3", "kg/m3"), 2600);
  EXPECT_EQ(in_unit("1.8 g/cm\u00b3", "kg/m^3"), 1800);
  EXPECT_EQ(in_unit("30\u00b0", "degrees"), 30);
  EXPECT_EQ(in_unit("9.81 m/s2", "m/s^2"), 9.81);
}

TEST(Units, OfAnotherQuantityAreNot) {
  EXPECT_EQ(in_unit("120 km/h", "m"), std::nullopt);
  EXPECT_EQ(in_unit("120 furlongs", "m"), std::nullopt);
  EXPECT_EQ(in_unit("5", "m"), std::nullopt);
  EXPECT_EQ(in_unit("mm", "m"), std::nullopt);
  EXPECT_EQ(in_unit("", "m"), std::nullopt);
}

}  // namespace
}  // namespace trackbed::input::units_test
