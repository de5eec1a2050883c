#include "solvers/disks/following_sweeps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <mutex>
#include <utility>
#include <vector>

#include "core/base/parallel.h"

namespace bipot {
namespace {

/// The tasks in the order in which they began.
std::vector<std::pair<int, int>> run(int threads, int sweeps, const std::vector<int>& ready) {
  FollowingSweeps following(ready);
  std::vector<std::pair<int, int>> order;
  std::mutex mutex;
  // Twice: nothing is left of the first run.
  for (int k = 0; k < 2; ++k) {
    order.clear();
    following.begin(sweeps);
    run_team(threads, [&](int rank, int size) {
      following.run(rank, size, [&](int sweep, int place) {
        const std::lock_guard<std::mutex> lock(mutex);
        order.emplace_back(sweep, place);
      });
    });
  }
  return order;
}

TEST(FollowingSweeps, EachTaskComesAfterThoseItNeeds) {
  const std::vector<int> ready{2, 2, 4, 6, 6, 6, 7};
  for (const int threads : {1, 2, 3}) {
    for (const int sweeps : {1, 2, 5}) {
      const auto order = run(std::min(threads, sweeps), sweeps, ready);
      ASSERT_EQ(order.size(), to_size(sweeps) * ready.size());
      std::vector<int> done(to_size(sweeps), 0);
      for (const auto& [sweep, place] : order) {
        EXPECT_EQ(place, done[to_size(sweep)]++) << "in order, once";
        if (sweep > 0) {
          EXPECT_GE(done[to_size(sweep) - 1], ready[to_size(place)]);
        }
      }
    }
  }
}

TEST(FollowingSweeps, FollowCloselyOnOneThread) {
  const auto order = run(1, 2, {2, 3, 4, 4});
  const std::vector<std::pair<int, int>> expected{{0, 0}, {0, 1}, {1, 0}, {0, 2},
                                                  {1, 1}, {0, 3}, {1, 2}, {1, 3}};
  EXPECT_EQ(order, expected);
}

}  // namespace
}  // namespace bipot
