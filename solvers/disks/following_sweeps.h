#pragma once

#include <atomic>
#include <utility>
#include <vector>

#include "core/base/types.h"
#include "solvers/disks/wavefront.h"

namespace bipot {

/// Runs sweeps over the same places in the same order, each close behind the one before it. Data of
/// one sweep in the cache then serve the next ones too. The result is that of one whole sweep after
/// the other, bit for bit.
class FollowingSweeps {
 public:
  /// `ready[place]`, which never decreases: number of places that a sweep must have done before the
  /// next one may process this place and all that share data with it.
  explicit FollowingSweeps(std::vector<int> ready) : ready_(std::move(ready)) {}

  int places() const { return static_cast<int>(ready_.size()); }

  /// Call before each run, by one thread.
  void begin(int sweeps) {
    if (to_size(sweeps) != progress_.size()) progress_ = std::vector<Progress>(to_size(sweeps));
    for (Progress& sweep : progress_) sweep.places.store(0, std::memory_order_relaxed);
  }
  /// Work of one member of a team: task(sweep, place) for some of the sweeps. Each waits only for
  /// the member with the previous sweep; hence there is no deadlock.
  template <class Task>
  void run(int rank, int size, const Task& task) {
    const int sweeps = static_cast<int>(progress_.size());
    const int first = sweeps * rank / size, last = sweeps * (rank + 1) / size;
    const auto next_of = [&](int sweep) {
      task(sweep, done(sweep));
      progress_[to_size(sweep)].places.fetch_add(1, std::memory_order_release);
    };
    for (int place = 0; place < places() && first < last; ++place) {
      if (first > 0) wait_for(progress_[to_size(first) - 1].places, ready_[to_size(place)]);
      next_of(first);
      for (int sweep = first + 1; sweep < last; ++sweep) {
        while (done(sweep) < places() && ready_[to_size(done(sweep))] <= done(sweep - 1)) {
          next_of(sweep);
        }
      }
    }
  }

 private:
  /// Places that a sweep has done, on its own line of the cache.
  struct alignas(64) Progress {
    std::atomic<int> places{0};
  };
  int done(int sweep) const {
    return progress_[to_size(sweep)].places.load(std::memory_order_relaxed);
  }

  std::vector<int> ready_;
  std::vector<Progress> progress_;
};

}  // namespace bipot
