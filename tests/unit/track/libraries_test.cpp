// Values of the libraries of rails and vehicles against their sources, and quantities that follow
// from vehicles and flats only.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "trackbed/core/types.hpp"
#include "trackbed/track/irregularity.hpp"
#include "trackbed/track/rail.hpp"
#include "trackbed/track/train.hpp"
#include "trackbed/track/wheel_rail.hpp"

namespace trackbed::track::libraries_test {
namespace {

// cm^2, cm^4, kg/m: EN 13674-1 (46E3, 54E1: mass from the area), TB/T 2341.
TEST(Libraries, Rails) {
  struct Row {
    const char* name;
    double area, inertia, mass;
  };
  for (const Row& row :
       {Row{"46E3", 59.44, 1606, 59.44e-4 * 7850}, Row{"54E1", 69.77, 2337.2, 69.77e-4 * 7850},
        Row{"60E1", 76.70, 3038.3, 60.21}, Row{"CHN60", 77.45, 3217, 60.64}}) {
    const RailSection section = rail_section(row.name);
    EXPECT_NEAR(section.area, 1e-4 * row.area, 1e-12) << row.name;
    EXPECT_NEAR(section.inertia, 1e-8 * row.inertia, 1e-15) << row.name;
    EXPECT_NEAR(section.mass, row.mass, 5e-3) << row.name;
  }
}

VehicleParameters of(const std::string& name) {
  VehicleParameters v;
  v.like = name;
  return complete(v);
}

// Axle loads, kN, and static deflections as published: values of half trains, single springs and
// sides are combined correctly.
TEST(Libraries, Vehicles) {
  const auto axle = [](const VehicleParameters& v) {
    return (v.body_mass + 2 * v.bogie_mass + 4 * v.wheelset_mass) / 4 * gravity / 1e3;
  };
  const VehicleParameters manchester = of("manchester_1"), alfa = of("alfa_pendular"),
                          wagon = of("freight_wagon");
  EXPECT_NEAR(axle(manchester), 109.09, 0.01);
  // Static deflections of its springs, mm.
  const double bogie = manchester.body_mass / 2 * gravity;
  EXPECT_NEAR(1e3 * bogie / manchester.secondary_stiffness, 182.51, 0.01);
  EXPECT_NEAR(1e3 * (bogie + manchester.bogie_mass * gravity) / 2 / manchester.primary_stiffness,
              37.42, 0.01);
  EXPECT_EQ(manchester.wheelbase, 2 * 1.28);
  EXPECT_EQ(manchester.bogie_distance, 2 * 9.5);
  EXPECT_NEAR(axle(alfa), 132.35, 0.01);
  EXPECT_NEAR(axle(wagon), 2 * (40500 + 2 * 900 + 4 * 700) / 4 * gravity / 1e3, 1e-9);
  EXPECT_EQ(wagon.secondary_stiffness, 2 * 6e6);
  EXPECT_EQ(wagon.secondary_damping, 2 * 6.5e4);
  EXPECT_EQ(wagon.primary_stiffness, 2 * 2.6e6);
  EXPECT_EQ(wagon.primary_damping, 2 * 1.5e4);
  EXPECT_EQ(wagon.bogie_distance, 2 * 7);
  EXPECT_EQ(wagon.wheelbase, 2 * 0.9);
  EXPECT_EQ(wagon.length, 17);
}

// m behind the first axle of two units; all axles have 25 t.
TEST(Libraries, PatternsOfForces) {
  const Train train({.vehicles = {"hxd1_unit", "hxd1_unit"}}, {}, 2);
  const std::array wanted = {0.0, 2.8, 9.0, 11.8, 17.611, 20.411, 26.611, 29.411};
  ASSERT_EQ(train.wheels().size(), wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    EXPECT_NEAR(train.wheels()[i].behind, wanted[i], 1e-12);
    EXPECT_NEAR(train.wheels()[i].force, 25e3 * gravity / 2, 1e-9);
  }
  const VehicleParameters model = of("load_model_71");
  double sum = 0;
  for (const double load : model.loads) sum += load;
  EXPECT_NEAR(sum, 4 * 250e3 + 2 * 10 * 80e3, 1e-6);
}

// Six classes, cm^2 rad/m; the root mean square is proportional to their square roots.
TEST(Libraries, FraClasses) {
  constexpr std::array amount = {1.2107, 1.0181, 0.6816, 0.5376, 0.2095, 0.0339};
  constexpr std::array classes = {Spectrum::fra_1, Spectrum::fra_2, Spectrum::fra_3,
                                  Spectrum::fra_4, Spectrum::fra_5, Spectrum::fra_6};
  for (std::size_t i = 0; i < classes.size(); ++i)
    EXPECT_NEAR(rms_of(classes[i], 3, 25), 8.541e-3 * std::sqrt(amount[i] / amount[0]), 1e-6) << i;
}

// For a body on one spring with a lateral offset e of its centre of mass, bounce and roll are
// coupled:
//   w^4 m I - w^2 (k (I + m e^2) + m k_r) + k k_r = 0,   k_r = k b^2/4, b the base of the springs.
TEST(Vehicles, AShiftedLoadCouplesBounceAndRoll) {
  VehicleParameters v;
  v.kind = VehicleKind::sprung;
  v.length = 2;
  v.body_mass = 9000;
  v.wheelset_mass = 1000;
  v.primary_stiffness = 1e6;
  v.primary_base = 2;
  v.body_roll = 5000;
  v.body_offset = 0.3;
  const double m = v.body_mass, i = v.body_roll, e = v.body_offset, k = v.primary_stiffness;
  const double roll = k * v.primary_base * v.primary_base / 4;
  const double b = (k * (i + m * e * e) + m * roll) / (m * i), c = k * roll / (m * i);
  const std::vector<double> found = natural_frequencies(v, true);
  ASSERT_EQ(found.size(), 2U);
  for (const int which : {0, 1}) {
    const double square = b / 2 + (which == 0 ? -1 : 1) * std::sqrt(b * b / 4 - c);
    const double hertz = std::sqrt(square) / (2 * std::numbers::pi);
    EXPECT_NEAR(found[static_cast<std::size_t>(which)], hertz, 1e-9 * hertz);
  }
}

// A flat touches the rail once in each turn of the wheel, and nowhere else.
TEST(Flats, StrikeOnceInATurn) {
  WheelRailParameters p;
  p.flat_axle = 2;
  p.flat_at = 7;
  const WheelRail law(p);
  const double turn = 2 * std::numbers::pi * p.bodies.wheel_radius;
  const double depth = p.flat_length * p.flat_length / (16 * p.bodies.wheel_radius);
  for (int turns = -3; turns <= 3; ++turns) {
    const double middle = p.flat_at + turns * turn;
    EXPECT_NEAR(law.flat(1, middle), depth, 1e-9 * depth);
    EXPECT_EQ(law.flat(0, middle), 0);
    for (double x = middle + 0.51 * p.flat_length; x < middle + turn - 0.51 * p.flat_length;
         x += 0.01)
      EXPECT_EQ(law.flat(1, x), 0) << x;
  }
}

}  // namespace
}  // namespace trackbed::track::libraries_test
