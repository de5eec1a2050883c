#pragma once

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include "core/parallel.h"

namespace bipot {

/// How far a thread has come in run_wavefront(): iterations done in the first and in the last tile
/// of its range. Each on a line of the cache of its own, as others wait for them.
struct alignas(64) RangeProgress {
  std::atomic<int> first{0};
  alignas(64) std::atomic<int> last{0};
};

/// Returns once `done` has reached `count`. The other thread is a fraction of an iteration away:
/// looking again is quicker than sleeping, but for machines that are busy with other work.
inline void wait_for(const std::atomic<int>& done, int count) {
  constexpr int kLooks = 4000;
  for (int k = 0; done.load(std::memory_order_acquire) < count; ++k) {
    if (k >= kLooks) std::this_thread::yield();
  }
}

/// Calls task(k, t) for all iterations k < `iterations` and tiles t < `tiles`, in an order in which
/// every (k, t) comes after (k, t - 1) and (k - 1, t + 1). With ContactTiles (contact_tiles.h) the
/// pairs that are left free then share no body, and the result is that of the plain loops over k and
/// t, bit for bit. The task must not throw.
///
/// One thread takes groups of `depth` iterations in waves t + 2 k = const, so that what an iteration
/// has in the cache serves the next ones too. Several threads have a range of tiles each, for all
/// iterations, and stay with it: a range may fit a core's own cache where the whole does not. Next
/// to each other they wait twice an iteration: for the left one's last tile of the same iteration,
/// and for the right one's first tile of the iteration before. Both stand earlier in the order of
/// waves, in which all proceed, so that nobody waits for ever; behind the left one by `depth`
/// ranges, a thread loses that part of `iterations`, so `depth` then is a quarter of them at most.
template <class Task>
void run_wavefront(int threads, int tiles, int iterations, int depth, const Task& task) {
  constexpr int kLeastTiles = 2;  // of a range
  constexpr int kDepthsInAll = 4;
  threads = std::clamp(threads, 1, std::max(1, tiles / kLeastTiles));
  if (threads > 1) depth = std::clamp(iterations / kDepthsInAll, 1, depth);
  std::vector<RangeProgress> progress(static_cast<std::size_t>(threads));
  const auto range = [&](int rank, int size) {
    RangeProgress* const own = progress.data() + rank;
    const int begin = tiles * rank / size, end = tiles * (rank + 1) / size;
    for (int start = 0; start < iterations; start += depth) {
      const int group = std::min(depth, iterations - start);
      for (int wave = begin; wave < end + 2 * (group - 1); ++wave) {
        const int first = wave < end ? 0 : (wave - end) / 2 + 1;
        const int last = std::min(group - 1, (wave - begin) / 2);
        for (int i = first; i <= last; ++i) {
          const int k = start + i, t = wave - 2 * i;
          if (t == begin && rank > 0) wait_for(own[-1].last, k + 1);
          if (t == end - 1 && rank + 1 < size) wait_for(own[1].first, k);
          task(k, t);
          if (t == begin) own->first.store(k + 1, std::memory_order_release);
          if (t == end - 1) own->last.store(k + 1, std::memory_order_release);
        }
      }
    }
  };
  run_team(threads, range);
}

}  // namespace bipot
