#include "core/scene/near_pairs.h"

#include "core/base/portable_random.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// Bodies that wander, fall together and go different ways; in a cell of width 20 if asked for.
template <int D>
void expect_complete(bool periodic) {
  PortableRandom draw(3);
  PeriodicCell cell{.in_x = periodic};
  cell.width.length = 20;
  std::vector<Body<D>> bodies(60);
  for (Body<D>& b : bodies) {
    for (int k = 0; k < D; ++k) b.x[k] = draw.between(0, D == 2 ? 20 : 8);
    b.radius = draw.between(0.5, 1);
    b.mass = 1;
  }
  NearPairs<D> near;
  int listed = 0;
  for (int k = 0; k < 40; ++k) {
    std::vector<double> ways;
    for (Body<D>& b : bodies) {
      for (int axis = 0; axis < D; ++axis) b.x[axis] += draw.between(-0.05, 0.05);
      b.x[0] += 3;
      ways.push_back(draw.between(0, 0.3));
    }
    std::set<std::pair<int, int>> pairs;
    for (const auto& pair : near.within(bodies, cell, ways, 0, 1)) pairs.emplace(pair.i, pair.j);
    listed += static_cast<int>(pairs.size());
    for (int i = 0; i < 60; ++i) {
      for (int j = i + 1; j < 60; ++j) {
        const Body<D>&a = bodies[to_size(i)], &b = bodies[to_size(j)];
        Vec<D> from = a.x - b.x;
        if (periodic) from[0] -= 20 * std::round(from[0] / 20);
        const double gap = from.norm() - a.radius - b.radius;
        if (gap > ways[to_size(i)] + ways[to_size(j)]) continue;
        EXPECT_TRUE(pairs.contains({i, j})) << i << " " << j << " in round " << k;
      }
    }
  }
  EXPECT_LT(listed, 40 * 60 * 59 / 4);
}

TEST(NearPairs, NoneIsMissedHoweverTheBodiesMove) {
  expect_complete<2>(false);
  expect_complete<3>(false);
  expect_complete<2>(true);
  expect_complete<3>(true);
}

}  // namespace
}  // namespace bipot
