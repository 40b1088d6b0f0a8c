// Influence coefficients of the rails against solutions for the whole track.
#include "track/passage/influence.hpp"

#include <gtest/gtest.h>

#include "trackbed/core/error.hpp"
#include "trackbed/track/newmark.hpp"

namespace trackbed::track::influence_test {
namespace {

constexpr double step = 2e-4;  // s

// Relative to the deflection at the force: both methods eliminate the same matrix.
constexpr double rounding = 1e-12;

LineParameters track(Dimension dimension) {
  LineParameters p;
  p.track.dimension = dimension;
  p.track.length = 60;
  p.track.zones = {{.from = 20, .to = 24, .rail = 1.5, .bed = 0.3, .side = ZoneSide::left}};
  return p;
}

// Wheels beyond the track, in pairs on an element, at nodes and between them, in arbitrary order.
std::vector<RailPoint> wheels(const Line& line) {
  std::vector<RailPoint> points;
  for (const double x : {21.37, -2.0, 0.0, 0.11, 21.3, 21.45, 60.0, 59.93, 63.0, 23.4, 45.0, 0.2})
    for (std::size_t side = 0; side < line.sides(); ++side) points.push_back(line.at(x, side));
  return points;
}

// Largest difference to unit forces on the whole track, relative to the largest flexibility.
double difference(const LineParameters& parameters) {
  const Line line(parameters);
  const std::vector<RailPoint> points = wheels(line);
  const Eigen::MatrixXd found =
      Influence(effective_stiffness(line.system(), step), line.rail_nodes()).between(points);
  const Newmark whole(line.system(), step);
  Eigen::MatrixXd expected = 0 * found;
  for (std::size_t j = 0; j < points.size(); ++j) {
    Vector unit = Vector::Zero(line.system().mass.rows());
    points[j].add(1, unit);
    const Vector u = whole.flexibility(unit);
    for (std::size_t i = 0; i < points.size(); ++i)
      expected(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          points[i].deflection(u);
  }
  EXPECT_GT(expected.maxCoeff(), 0);
  EXPECT_EQ(found, found.transpose());
  return (found - expected).cwiseAbs().maxCoeff() / expected.maxCoeff();
}

TEST(Influence, EqualsASolveOfTheWholeTrack) {
  EXPECT_LT(difference(track(Dimension::plane)), rounding);
  EXPECT_LT(difference(track(Dimension::space)), rounding);
}

// With 1e8 N/m below a pad of 1e25 N/m all digits are lost: it is refused.
TEST(Influence, RefusesIllConditionedStiffnesses) {
  LineParameters p = track(Dimension::plane);
  p.pad.stiffness = 1e25;
  const Line line(p);
  EXPECT_THROW(Influence(effective_stiffness(line.system(), step), line.rail_nodes()), InputError);
  EXPECT_THROW(Newmark(line.system(), step), InputError);
}

TEST(Influence, IncludesTheSupportsOfTheRails) {
  LineParameters p = track(Dimension::space);
  p.ballast.mass = 300;
  p.under_sleeper.stiffness = 200e6;
  p.under_sleeper.damping = 10e3;
  EXPECT_LT(difference(p), rounding);
  p = track(Dimension::space);
  p.track.sleeper.model = SleeperModel::beam;
  EXPECT_LT(difference(p), rounding);
  p = track(Dimension::space);
  p.first_moved = 40, p.moved = 5;
  EXPECT_LT(difference(p), rounding);
}

TEST(Influence, IsCorrectWithoutSleepersAndWithFreeEnds) {
  LineParameters p = track(Dimension::plane);
  p.track.support = Support::continuous;
  p.track.ends = RailEnds::free;
  p.track.elements = 1;
  EXPECT_LT(difference(p), rounding);
}

// Negligible responses are set to zero, without underflow.
TEST(Influence, DecaysAlongALongTrack) {
  LineParameters p = track(Dimension::space);
  p.track.length = 300;
  const Line line(p);
  const std::vector<RailPoint> points{line.at(1), line.at(299, 1), line.at(298), line.at(2, 1)};
  const Eigen::MatrixXd found =
      Influence(effective_stiffness(line.system(), step), line.rail_nodes()).between(points);
  EXPECT_EQ(found(0, 1), 0);
  EXPECT_EQ(found(2, 3), 0);
  EXPECT_NE(found(0, 3), 0);
  EXPECT_NE(found(1, 2), 0);
}

}  // namespace
}  // namespace trackbed::track::influence_test
