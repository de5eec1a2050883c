#include "core/linear/supernodes.h"

#include "core/linear/frontal_tree.h"
#include "tests/support/grid_matrix.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

using Edges = std::vector<std::pair<int, int>>;

/// Fronts of the pattern with these edges, in the given order, whose factor has no other entries.
Supernodes fronts_of(int n, const Edges& edges, const std::vector<std::int64_t>& entries) {
  Triplets list;
  for (int k = 0; k < n; ++k) list.emplace_back(k, k, 1.0);
  for (const auto& [i, j] : edges) {
    list.emplace_back(i, j, 1.0);
    list.emplace_back(j, i, 1.0);
  }
  const SparseMatrix A = from_triplets(n, n, list);
  std::vector<int> order(to_size(n));
  std::iota(order.begin(), order.end(), 0);
  return supernodes(A, order, entries);
}

TEST(Supernodes, ColumnsWithoutCouplingAreFrontsByThemselves) {
  const Supernodes fronts = fronts_of(3, {}, {1, 1, 1});
  EXPECT_EQ(fronts.first, (std::vector<int>{0, 1, 2, 3}));
  EXPECT_TRUE(fronts.below.empty());
}

/// Leaves 0 to 4 of a star hang on 5. Leaf after leaf joins the front of its parent, which then
/// begins behind the next one. Three join for nothing (up to four columns), the fourth stores 3
/// zeros among 15 numbers, below 0.3. The last would make it 7 of 21.
TEST(Supernodes, LeavesJoinTheFrontOfTheirParent) {
  const Supernodes fronts =
      fronts_of(6, {{0, 5}, {1, 5}, {2, 5}, {3, 5}, {4, 5}}, {2, 2, 2, 2, 2, 1});
  EXPECT_EQ(fronts.first, (std::vector<int>{0, 1, 6}));
  EXPECT_EQ(fronts.below, (std::vector<int>{5}));
  EXPECT_EQ(fronts.below_start, (std::vector<int>{0, 1, 1}));
}

/// A chain of 12: each column has one entry below the diagonal. From the end, the last four join
/// for nothing. The fifth stores 3 zeros among 15 numbers, below 0.3. The sixth would make it 7 of
/// 21, which is not. It begins the next front, with one row below: four for nothing, the fifth
/// stores 4 zeros of 20, the sixth would make it 9 of 27. Two columns are left.
TEST(Supernodes, AChainJoinsWhileFewZerosAreStored) {
  Edges chain;
  for (int k = 0; k < 11; ++k) chain.emplace_back(k, k + 1);
  std::vector<std::int64_t> entries(12, 2);
  entries.back() = 1;
  const Supernodes fronts = fronts_of(12, chain, entries);
  EXPECT_EQ(fronts.first, (std::vector<int>{0, 2, 7, 12}));
  EXPECT_EQ(fronts.below, (std::vector<int>{2, 7}));
}

/// Rows of a front hold those of its children below it: what an elimination needs.
TEST(Supernodes, AFrontHasTheRowsOfItsChildren) {
  const auto tree = FrontalTree::analyse(grid_matrix(25, 2, 3, 2));
  ASSERT_GT(tree->num_fronts(), 50);
  std::vector<int> front_of(to_size(tree->size()));
  for (int s = 0; s < tree->num_fronts(); ++s) {
    for (int j = tree->first[to_size(s)]; j < tree->first[to_size(s) + 1]; ++j) {
      front_of[to_size(j)] = s;
    }
  }
  for (int s = 0; s < tree->num_fronts(); ++s) {
    const auto rows = [&](int front) {
      return std::vector<int>(tree->below.begin() + tree->below_start[to_size(front)],
                              tree->below.begin() + tree->below_start[to_size(front) + 1]);
    };
    const std::vector<int> own = rows(s);
    ASSERT_TRUE(std::is_sorted(own.begin(), own.end()));
    if (own.empty()) continue;
    const int parent = front_of[to_size(own[0])];
    std::vector<int> above = rows(parent);
    for (int j = tree->first[to_size(parent)]; j < tree->first[to_size(parent) + 1]; ++j) {
      above.push_back(j);
    }
    std::sort(above.begin(), above.end());
    EXPECT_TRUE(std::includes(above.begin(), above.end(), own.begin(), own.end())) << s;
  }
}

}  // namespace
}  // namespace bipot
