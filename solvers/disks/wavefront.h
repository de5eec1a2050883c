#pragma once

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include "core/base/parallel.h"

namespace bipot {

/// Returns once `done` has reached `count`. Polls, since the other thread is nearly there. Yields
/// after many polls, for machines that are busy with other work.
inline void wait_for(const std::atomic<int>& done, int count) {
  constexpr int kLooks = 4000;
  for (int k = 0; done.load(std::memory_order_acquire) < count; ++k) {
    if (k >= kLooks) std::this_thread::yield();
  }
}

/// Number of iterations in flight, and of places that each processes in a wave before the next one
/// follows. The data of these places are then in a core's own cache, except for the first
/// iteration.
struct Pipeline {
  int depth = 1, places = 2;
};

/// In wave w, iteration i processes the places p with ⌊(p + i)/places⌋ = w, in the order of i.
/// Hence (i, p) runs after (i, p - 1) and (i - 1, p + 1). For places = 2, the waves are
///
///     place         0  1  2  3  4  5
///     iteration 0   0  0  1  1  2  2
///     iteration 1   0  1  1  2  2  3
///     iteration 2   1  1  2  2  3  3
inline int wave_of(int place, int i, int places) { return (place + i) / places; }

/// Calls task(start + i, place) for the places begin <= place < end of a wave.
template <class Task>
void run_part_of_wave(int begin, int end, int start, int i, int wave, int places,
                      const Task& task) {
  const int first = places * wave - i;
  for (int place = std::max(begin, first); place < std::min(end, first + places); ++place) {
    task(start + i, place);
  }
}
/// The same for the iterations i < group of the waves from `first` to before `last`.
template <class Task>
void run_waves(int begin, int end, int start, int group, int first, int last, int places,
               const Task& task) {
  for (int wave = first; wave < last; ++wave) {
    for (int i = 0; i < group; ++i) run_part_of_wave(begin, end, start, i, wave, places, task);
  }
}
/// The first wave after those of run_waves().
inline int end_of_waves(int end, int group, int places) {
  return wave_of(end - 1, group - 1, places) + 1;
}

/// The first tile of the upper half, which run_wavefront() processes downwards.
inline int first_upper_tile(int tiles) { return tiles / 2; }
/// Position of a tile in the order of an iteration, from 0: up the lower half, then down the upper
/// one.
inline int turn_of_tile(int tile, int tiles) {
  const int middle = first_upper_tile(tiles);
  return tile < middle ? tile : tiles - 1 - tile + middle;
}

/// Calls task(k, t) for all iterations k < `iterations` and tiles t < `tiles`, from both ends of
/// the packing to its middle. In the lower half of the tiles (k, t) runs after (k, t - 1) and (k -
/// 1, t + 1), in the upper half after (k, t + 1) and (k - 1, t - 1). The first tile of the upper
/// half runs after the last of the lower one. With ContactTiles (contact_tiles.h) the remaining
/// pairs share no body. The result is then that of plain loops over k and over t in that order, bit
/// for bit. The task must not throw.
///
/// One thread takes groups of pipeline.depth iterations in waves, so that cached data of an
/// iteration serve the next ones too. First come waves of the lower half that do not need the upper
/// one, then those of the upper one, then both alternately.
///
/// Several threads have a fixed range of tiles each, for all iterations, since a range may fit a
/// core's own cache. Two threads begin at both ends and meet in the middle; with more, there are as
/// many ranges in each half. Neighbouring ranges wait twice in an iteration: for the last tile of
/// the range behind in the same iteration, and for the first tile of the one ahead in the iteration
/// before. Both come earlier in the order of waves and, within a wave, of iterations. All threads
/// follow this order; hence there is no deadlock.
template <class Task>
void run_wavefront(int threads, int tiles, int iterations, Pipeline pipeline, const Task& task) {
  // Iterations that a thread has done in the first and in the last tile of its range. Each on its
  // own line of the cache, as others wait for them.
  struct alignas(64) RangeProgress {
    std::atomic<int> first{0};
    alignas(64) std::atomic<int> last{0};
  };
  constexpr int kLeastTiles = 2;  // of a range
  // A thread that follows another one by the iterations in flight idles for that part of the
  // iterations.
  constexpr int kDepthsInAll = 4;
  const int middle = first_upper_tile(tiles), above = tiles - middle;
  const auto upper = [&](int k, int place) { task(k, tiles - 1 - place); };
  threads = std::clamp(threads, 1, std::max(1, tiles / kLeastTiles));
  const int together = pipeline.places;
  int depth = pipeline.depth;
  if (threads > 2) depth = std::clamp(iterations / kDepthsInAll, 1, depth);
  std::vector<RangeProgress> progress(static_cast<std::size_t>(threads));

  const auto alone = [&] {
    for (int start = 0; start < iterations; start += depth) {
      const int group = std::min(depth, iterations - start);
      // The upper half waits for the last place of the lower one, whose next iteration waits for
      // it.
      const int lower_alone = wave_of(middle, 0, together),
                upper_alone = wave_of(above - 1, 0, together);
      run_waves(0, middle, start, group, 0, lower_alone, together, task);
      run_waves(0, above, start, group, 0, upper_alone, together, upper);
      const int end = end_of_waves(above, group, together);
      for (int wave = std::min(lower_alone, upper_alone); wave < end; ++wave) {
        for (int i = 0; i < group; ++i) {
          if (wave >= lower_alone) run_part_of_wave(0, middle, start, i, wave, together, task);
          if (wave >= upper_alone) run_part_of_wave(0, above, start, i, wave, together, upper);
        }
      }
    }
  };
  const auto member = [&](int rank, int size) {
    if (size == 1) return alone();
    const int below = size / 2;  // threads in the lower half
    const bool up = rank >= below;
    const int here = up ? rank - below : rank, ranges = up ? size - below : below;
    const int places = up ? above : middle;
    const int begin = places * here / ranges, end = places * (here + 1) / ranges;
    RangeProgress* const own = progress.data() + rank;
    // The last ranges of both halves meet.
    const bool meets = here + 1 == ranges;
    const std::atomic<int>& ahead =
        meets ? progress[static_cast<std::size_t>(up ? below : size) - 1].last : own[1].first;
    for (int start = 0; start < iterations; start += depth) {
      const int group = std::min(depth, iterations - start);
      run_waves(begin, end, start, group, wave_of(begin, 0, together),
                end_of_waves(end, group, together), together, [&](int k, int place) {
                  if (place == begin && here > 0) wait_for(own[-1].last, k + 1);
                  if (place == end - 1) wait_for(ahead, meets && up ? k + 1 : k);
                  if (up) {
                    upper(k, place);
                  } else {
                    task(k, place);
                  }
                  if (place == begin) own->first.store(k + 1, std::memory_order_release);
                  if (place == end - 1) own->last.store(k + 1, std::memory_order_release);
                });
    }
  };
  run_team(threads, member);
}

}  // namespace bipot
