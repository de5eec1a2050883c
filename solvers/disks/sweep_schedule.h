#pragma once

#include <atomic>
#include <vector>

#include "core/base/parallel.h"
#include "solvers/disks/tile_links.h"
#include "solvers/disks/wavefront.h"

namespace bipot {

/// Order of the tiles of several sweeps for a team of threads. A tile waits for its predecessors
/// only: the tiles that come to one of its bodies just before it, in the same sweep and in the
/// sweep before. So every body sees the sequence of contacts of one whole sweep after the other,
/// and the result has the same bits for any number of threads. (Doacross loops with dependences of
/// data: Saltz, Mirchandaney and Crowley, IEEE Trans. Comput. 40, 1991.)
///
/// One thread lets each sweep follow the one before it closely: data in the cache then serve
/// several sweeps. For a team the tiles are dealt out beforehand, as if each took the time of its
/// work (Graham's list scheduling). The thread that is free first takes a tile that it had in the
/// sweep before, whose data may be in its cache. If those wait, it goes on with its sweep at a tile
/// next to its last one, else with the first tile in the order of one thread which does not wait.
/// All wait for earlier tiles of that plan only. Hence there is no deadlock, whatever times are
/// taken.
class SweepSchedule {
 public:
  /// Sweeps of one direction, then perhaps others down.
  struct Sweeps {
    int up = 1, down = 0;
    int all() const { return up + down; }
  };
  /// `work`: of each tile. `threads`: at most; fewer if a third of their time would be lost.
  SweepSchedule(const TileLinks& links, const std::vector<int>& work, Sweeps sweeps, int threads);

  int threads() const { return static_cast<int>(plans_.size()); }
  /// Time of one thread over that of the team, if nothing but the work takes time.
  double gain() const { return gain_; }

  /// Calls task(sweep, tile) for all, with the plan of the team or, with `alone`, by one thread.
  template <class Task>
  void run(bool alone, const Task& task) {
    const auto call = [&](int item) { task(item / tiles_, item % tiles_); };
    const auto all = [&] {
      for (const int item : order_) call(item);
    };
    if (alone || threads() == 1) return all();
    for (Progress& of : progress_) of.done.store(0, std::memory_order_relaxed);
    run_team(threads(), [&](int rank, int size) {
      // The system may give fewer threads than planned.
      if (size == threads()) {
        follow(rank, call);
      } else if (rank == 0) {
        all();
      }
    });
  }

 private:
  /// Items that a thread has done, on its own line of the cache.
  struct alignas(64) Progress {
    std::atomic<int> done{0};
  };
  struct Wait {
    int thread, count;
  };
  /// Items of a thread, each after the waits up to end_of_waits.
  struct Plan {
    std::vector<int> items, end_of_waits;
    std::vector<Wait> waits;
  };

  template <class Call>
  void follow(int rank, const Call& call) {
    const Plan& plan = plans_[to_size(rank)];
    int wait = 0;
    for (int k = 0; k < static_cast<int>(plan.items.size()); ++k) {
      for (; wait < plan.end_of_waits[to_size(k)]; ++wait) {
        const Wait& next = plan.waits[to_size(wait)];
        wait_for(progress_[to_size(next.thread)].done, next.count);
      }
      call(plan.items[to_size(k)]);
      progress_[to_size(rank)].done.store(k + 1, std::memory_order_release);
    }
  }

  int tiles_;
  double gain_ = 1;
  std::vector<int> order_;  // sweep * tiles + tile
  std::vector<Plan> plans_;
  std::vector<Progress> progress_;
};

}  // namespace bipot
