#include "core/base/parallel.h"

#include <atomic>

#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(Parallel, EveryTaskRunsOnceAndPhasesComeInOrder) {
  const std::vector<int> first{0, 3, 1}, last{40, 7, 90};
  for (const int threads : {1, 2, 3, 4}) {
    std::vector<std::atomic<int>> calls(300);
    std::atomic<int> done{0};
    std::atomic<bool> too_early{false};
    const auto task = [&](int phase, int k) {
      ++calls[static_cast<std::size_t>(100 * phase + k)];
      if (done++ < (phase == 0 ? 0 : (phase == 1 ? 40 : 44))) too_early = true;
    };
    run_phases(threads, 3, first.data(), last.data(), task);
    EXPECT_FALSE(too_early) << threads;
    for (int phase = 0; phase < 3; ++phase) {
      for (int k = 0; k < 100; ++k) {
        const auto at = static_cast<std::size_t>(phase);
        EXPECT_EQ(calls[100 * at + static_cast<std::size_t>(k)],
                  k >= first[at] && k < last[at] ? 1 : 0);
      }
    }
  }
}

TEST(Parallel, TheFirstFailureIsThrownAndLaterPhasesDoNotBegin) {
  for (const int threads : {1, 2, 4}) {
    const std::vector<int> first{0, 0}, last{50, 50};
    std::atomic<int> second{0};
    const auto task = [&](int phase, int k) {
      if (phase == 1) ++second;
      if (k == 17 || k == 31) throw std::runtime_error(std::to_string(k));
    };
    try {
      run_phases(threads, 2, first.data(), last.data(), task);
      ADD_FAILURE() << "nothing was thrown";
    } catch (const std::runtime_error& e) {
      EXPECT_STREQ(e.what(), "17");
    }
    EXPECT_EQ(second, 0);
  }
}

/// A thread that is ahead fails in a phase that others have not begun: none waits for ever.
TEST(Parallel, AFailureOfALaterPhaseEndsAllThreads) {
  const std::vector<int> first{0, 0, 0}, last{2, 2, 2};
  for (int turn = 0; turn < 500; ++turn) {
    const auto task = [](int phase, int) {
      if (phase > 0) throw std::runtime_error("second");
    };
    EXPECT_THROW(run_phases(2, 3, first.data(), last.data(), task), std::runtime_error);
  }
}

TEST(Parallel, LoopsInsideOneThreadHaveOneThread) {
  const auto team = [] {
    std::atomic<int> members{0};
    run_team(4, [&](int, int) { ++members; });
    return members.load();
  };
  const int before = team();
  {
    const OneThread one_thread;
    EXPECT_EQ(team(), 1);
  }
  EXPECT_EQ(team(), before);
}

TEST(Parallel, PiecesCoverTheItems) {
  for (const int items : {0, 1, kPieceItems, 5 * kPieceItems + 3}) {
    std::vector<int> count(static_cast<std::size_t>(items), 0);
    run_pieces(3, items, [&](int begin, int end) {
      EXPECT_EQ(begin % kPieceItems, 0);
      for (int k = begin; k < end; ++k) ++count[static_cast<std::size_t>(k)];
    });
    for (const int c : count) ASSERT_EQ(c, 1);
  }
}

}  // namespace
}  // namespace bipot
