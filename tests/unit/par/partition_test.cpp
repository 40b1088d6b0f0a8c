// Partitions: every item has a part, weights are even, and the result depends on the input alone.
#include "trackbed/par/partition.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace trackbed::par::partition_test {
namespace {

std::vector<double> sums(std::span<const int> part_of, std::span<const double> weights, int parts) {
  std::vector<double> sum(static_cast<std::size_t>(parts), 0.0);
  for (std::size_t k = 0; k < part_of.size(); ++k)
    sum.at(static_cast<std::size_t>(part_of[k])) += weights[k];
  return sum;
}

// Largest sum of weights over the mean.
double unevenness(const std::vector<double>& sum) {
  return *std::max_element(sum.begin(), sum.end()) * static_cast<double>(sum.size()) /
         std::accumulate(sum.begin(), sum.end(), 0.0);
}

TEST(Bisect, CutsALongBedAcrossItsLength) {
  std::vector<Vec3> points;
  for (int x = 0; x < 12; ++x)
    for (int z = 0; z < 2; ++z) points.emplace_back(x, 0, z);
  const std::vector<double> weights(points.size(), 1.0);
  const std::vector<int> part_of = bisect(points, weights, 3);
  for (std::size_t k = 0; k < points.size(); ++k)
    EXPECT_EQ(part_of[k], static_cast<int>(points[k].x()) / 4) << points[k].x();
}

// Each halving puts one point on either side: the largest error is that of half a point per level.
TEST(Bisect, EvensOutWeights) {
  std::mt19937 draw(7);
  std::uniform_real_distribution<double> number(0.1, 1);
  std::vector<Vec3> points(2000);
  std::vector<double> weights(points.size());
  for (std::size_t k = 0; k < points.size(); ++k) {
    points[k] = Vec3(4 * number(draw), number(draw), number(draw));
    weights[k] = number(draw);
  }
  for (const int parts : {2, 3, 5, 8}) {
    const std::vector<int> part_of = bisect(points, weights, parts);
    EXPECT_LT(unevenness(sums(part_of, weights, parts)), 1.02) << parts;
  }
}

TEST(Bisect, SplitsPointsAtOnePlaceByTheirNumber) {
  const std::vector<Vec3> points(6, Vec3(1, 2, 3));
  const std::vector<double> weights(6, 1.0);
  EXPECT_EQ(bisect(points, weights, 3), (std::vector<int>{0, 0, 1, 1, 2, 2}));
}

TEST(Bisect, LeavesPartsEmptyIfThereAreFewerPoints) {
  const std::vector<Vec3> points{Vec3(0, 0, 0), Vec3(1, 0, 0)};
  const std::vector<double> weights(2, 1.0);
  const std::vector<int> part_of = bisect(points, weights, 4);
  EXPECT_NE(part_of[0], part_of[1]);
  EXPECT_TRUE(bisect({}, {}, 4).empty());
}

// A chain of vertices: the best partition cuts it in equal pieces.
Graph chain(std::size_t n) {
  Graph graph;
  for (std::size_t v = 0; v < n; ++v) {
    if (v > 0) graph.neighbours.push_back(static_cast<std::int32_t>(v - 1));
    if (v + 1 < n) graph.neighbours.push_back(static_cast<std::int32_t>(v + 1));
    graph.begin.push_back(static_cast<std::int64_t>(graph.neighbours.size()));
  }
  graph.weights.assign(n, 1.0);
  graph.edge_weights.assign(graph.neighbours.size(), 0.5);
  return graph;
}

TEST(PartitionGraph, CutsAChainIntoPieces) {
  const Graph graph = chain(120);
  const std::vector<int> part_of = partition_graph(graph, 4);
  ASSERT_EQ(part_of.size(), 120u);
  int cuts = 0;
  for (std::size_t v = 1; v < part_of.size(); ++v) cuts += part_of[v] != part_of[v - 1];
  EXPECT_EQ(cuts, 3);
  EXPECT_LT(unevenness(sums(part_of, graph.weights, 4)), 1.05);
}

TEST(PartitionGraph, IsEmptyWithFewerVerticesThanParts) {
  EXPECT_TRUE(partition_graph(chain(3), 4).empty());
}

// Two halves of a chain of four: each has the weight 2 and cuts one edge of 0.5.
TEST(WorstPart, CountsWeightsAndEdgesThatAreCut) {
  const std::vector<int> halves{0, 0, 1, 1}, one(4, 0);
  EXPECT_DOUBLE_EQ(worst_part(chain(4), halves, 2), (2 + 0.5) / 2);
  EXPECT_DOUBLE_EQ(worst_part(chain(4), one, 1), 1);
}

// A row of quadrilaterals, of which two share a side.
TEST(PartitionMesh, CutsARowOfElementsOnce) {
  std::vector<std::int32_t> nodes;
  constexpr std::int32_t count = 40;
  for (std::int32_t e = 0; e < count; ++e)
    nodes.insert(nodes.end(), {2 * e, 2 * e + 2, 2 * e + 3, 2 * e + 1});
  const std::vector<double> weights(count, 1.0);
  const std::vector<int> part_of = partition_mesh(nodes, 4, 2, weights, 2);
  ASSERT_EQ(part_of.size(), static_cast<std::size_t>(count));
  int cuts = 0;
  for (std::size_t e = 1; e < part_of.size(); ++e) cuts += part_of[e] != part_of[e - 1];
  EXPECT_EQ(cuts, 1);
  EXPECT_LT(unevenness(sums(part_of, weights, 2)), 1.06);
}

}  // namespace
}  // namespace trackbed::par::partition_test
