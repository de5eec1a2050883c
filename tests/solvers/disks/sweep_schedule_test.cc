#include "solvers/disks/sweep_schedule.h"

#include <mutex>
#include <thread>

#include "tests/support/test.h"

namespace bipot {
namespace {

/// Tiles 0 to n - 1 in `rows` of equal length: each shares bodies with the one before it in its row
/// and with those below and below to the right, as in a triangular packing.
TileLinks packing(int rows, int length) {
  const int tiles = rows * length;
  std::vector<std::vector<int>> before(to_size(tiles)), after(before);
  for (int t = 0; t < tiles; ++t) {
    const int x = t % length;
    if (x > 0) before[to_size(t)].push_back(t - 1);
    if (t >= length) before[to_size(t)].push_back(t - length);
    if (t >= length && x + 1 < length) before[to_size(t)].push_back(t - length + 1);
    for (const int other : before[to_size(t)]) after[to_size(other)].push_back(t);
  }
  const auto joined = [&](const std::vector<std::vector<int>>& lists, bool with_own) {
    return make_lists(tiles, [&](const auto& put) {
      for (int t = 0; t < tiles; ++t) {
        if (with_own) put(t, t);
        for (const int other : lists[to_size(t)]) put(t, other);
      }
    });
  };
  return {
      tiles, joined(before, false), joined(after, false), joined(before, true), joined(after, true),
      {}};
}

using Items = std::vector<std::pair<int, int>>;

/// The tasks in the order in which they ended.
Items run(SweepSchedule& schedule, bool alone = false) {
  Items order;
  std::mutex mutex;
  // Twice: nothing is left of the first run.
  for (int k = 0; k < 2; ++k) {
    order.clear();
    schedule.run(alone, [&](int sweep, int tile) {
      const std::lock_guard<std::mutex> lock(mutex);
      order.emplace_back(sweep, tile);
    });
  }
  return order;
}

void check_order(const TileLinks& links, SweepSchedule::Sweeps sweeps, const Items& order) {
  ASSERT_EQ(order.size(), to_size(links.tiles * sweeps.all()));
  std::set<std::pair<int, int>> done;
  for (const auto& [sweep, tile] : order) {
    const bool up = sweep < sweeps.up, up_before = sweep - 1 < sweeps.up;
    for (const int t : (up ? links.before : links.after).of(tile)) {
      EXPECT_TRUE(done.count({sweep, t})) << sweep << ", " << tile << " before " << t;
    }
    if (sweep > 0) {
      for (const int t : (up_before ? links.last : links.first).of(tile)) {
        EXPECT_TRUE(done.count({sweep - 1, t})) << sweep << ", " << tile << " before " << t;
      }
    }
    EXPECT_TRUE(done.insert({sweep, tile}).second) << "twice";
  }
}

TEST(SweepSchedule, OnAnyNumberOfThreadsEachTileComesAfterThoseThatItWaitsFor) {
  const TileLinks links = packing(6, 5);
  const std::vector<int> work(30, 1);
  for (const SweepSchedule::Sweeps sweeps : {SweepSchedule::Sweeps{1, 0}, {2, 2}, {5, 5}}) {
    for (const int threads : {1, 2, 3, 8}) {
      SweepSchedule schedule(links, work, sweeps, threads);
      check_order(links, sweeps, run(schedule));
      check_order(links, sweeps, run(schedule, true));
    }
  }
}

TEST(SweepSchedule, OneThreadLetsSweepsFollowClosely) {
  // A chain: tile t + 1 is the last one with a body of tile t.
  SweepSchedule schedule(packing(1, 4), {1, 1, 1, 1}, {2, 1}, 1);
  const Items expected{{0, 0}, {0, 1}, {1, 0}, {0, 2}, {1, 1}, {0, 3},
                       {1, 2}, {1, 3}, {2, 3}, {2, 2}, {2, 1}, {2, 0}};
  EXPECT_EQ(run(schedule), expected);
}

TEST(SweepSchedule, ThreadsKeepTheirTiles) {
  constexpr int kTiles = 800, kUp = 2, kAll = 4;
  SweepSchedule schedule(packing(40, 20), std::vector<int>(kTiles, 1), {kUp, kAll - kUp}, 2);
  ASSERT_EQ(schedule.threads(), 2);
  std::vector<std::thread::id> thread(kTiles * kAll);
  schedule.run(false, [&](int sweep, int tile) {
    thread[to_size(sweep * kTiles + tile)] = std::this_thread::get_id();
  });
  int kept = 0;
  for (int item = kTiles; item < kTiles * kAll; ++item) {
    if (thread[to_size(item)] == thread[to_size(item - kTiles)]) ++kept;
  }
  EXPECT_GT(kept, 0.8 * kTiles * (kAll - 1));
}

TEST(SweepSchedule, ThreadsThatWouldWaitAreLeftOut) {
  // In a chain of 4 tiles two sweeps each way overlap but for 3 tiles at each turn: the time is at
  // least 2 (4 + 2) for 16 tiles, a gain of 4/3.
  const SweepSchedule chain(packing(1, 4), {1, 1, 1, 1}, {2, 2}, 16);
  EXPECT_EQ(chain.threads(), 2);
  EXPECT_DOUBLE_EQ(chain.gain(), 16.0 / 12);
  // Rows of 20 tiles that follow with a distance of two keep ten threads busy at most.
  const SweepSchedule wide(packing(40, 20), std::vector<int>(800, 1), {1, 0}, 4);
  EXPECT_EQ(wide.threads(), 4);
  EXPECT_GT(wide.gain(), 3.8);
}

}  // namespace
}  // namespace bipot
