// Recursive coordinate bisection.

#include "solvers/parallel/cell_tree.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

std::vector<double> loads(const CellTree& tree, const std::vector<Vec3>& points,
                          const std::vector<double>& weights) {
  std::vector<double> load(to_size(tree.cells()), 0.0);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const int cell = tree.cell_of(points[k]);
    EXPECT_GE(cell, 0);
    EXPECT_LT(cell, tree.cells());
    load[to_size(cell)] += weights[k];
  }
  return load;
}

TEST(CellTree, CellsCarryEqualWeights) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> place(0, 1), weight(0, 6);
  std::vector<Vec3> points(3000);
  std::vector<double> weights(points.size());
  for (std::size_t k = 0; k < points.size(); ++k) {
    // Denser to the left, and a longer box than high.
    points[k] = Vec3(4 * std::pow(place(engine), 2), place(engine), 0);
    weights[k] = weight(engine);
  }
  for (const int cells : {1, 2, 3, 4, 7, 16}) {
    // Each cut misses by at most half a weight of 6, at most 4 of them above each other.
    const std::vector<double> load = loads(CellTree(points, weights, cells), points, weights);
    EXPECT_LE(imbalance(load), 1 + 4 * 3.0 / (9000.0 / cells)) << cells;
  }
}

TEST(CellTree, TheLongestSideIsCutFirst) {
  std::vector<Vec3> points;
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 2; ++j) points.push_back(Vec3(j, 0, i));
  }
  const std::vector<double> weights(points.size(), 1.0);
  const CellTree tree(points, weights, 2);
  for (const Vec3& x : points) EXPECT_EQ(tree.cell_of(x), x[2] < 3.5 ? 0 : 1);
}

TEST(CellTree, PointsWithOneCoordinateStayTogetherAndCellsMayBeEmpty) {
  const std::vector<Vec3> points(5, Vec3(1, 2, 3));
  const std::vector<double> weights(5, 1.0);
  const std::vector<double> load = loads(CellTree(points, weights, 3), points, weights);
  EXPECT_EQ(*std::max_element(load.begin(), load.end()), 5);
  const CellTree empty(std::vector<Vec3>{}, std::vector<double>{}, 4);
  EXPECT_GE(empty.cell_of(Vec3::Zero()), 0);
}

TEST(CellTree, WithoutWeightsPointsCount) {
  std::vector<Vec3> points;
  for (int i = 0; i < 10; ++i) points.push_back(Vec3(i, 0, 0));
  const std::vector<double> nothing(10, 0.0), ones(10, 1.0);
  EXPECT_EQ(loads(CellTree(points, nothing, 2), points, ones), (std::vector<double>{5, 5}));
}

TEST(CellTree, BadInputIsRefused) {
  const std::vector<Vec3> points{Vec3::Zero(), Vec3(1, kNaN, 0)};
  const std::vector<double> one{1.0}, two{1.0, 1.0}, negative{1.0, -1.0};
  EXPECT_THROW(CellTree(points, two, 2), std::invalid_argument);
  EXPECT_THROW(CellTree(std::span(points).first(1), two, 2), std::invalid_argument);
  EXPECT_THROW(CellTree(std::span(points).first(1), one, 0), std::invalid_argument);
  const std::vector<Vec3> good{Vec3::Zero(), Vec3(1, 0, 0)};
  EXPECT_THROW(CellTree(good, negative, 2), std::invalid_argument);
}

TEST(CellTree, ImbalanceIsTheLargestOverTheMean) {
  EXPECT_EQ(imbalance(std::vector<double>{3, 1, 2, 2}), 1.5);
  EXPECT_EQ(imbalance(std::vector<double>{0, 0}), 1);
}

}  // namespace
}  // namespace bipot
