#pragma once

#include <mutex>

namespace bipot {

/// During its life, no other thread has one: it stands around calls of dense kernels. OpenBLAS's
/// serial build shares buffers between threads without locks (its option USE_LOCKING), and would
/// return wrong numbers. A thread may take several.
class DenseTurn {
 public:
  DenseTurn();

  /// Calls f while others may have their turn: a callback may wait for them. For the only turn of
  /// this thread.
  template <class F>
  auto outside(F&& f) {
    struct Again {
      ~Again() { turn.lock(); }
      std::unique_lock<std::recursive_mutex>& turn;
    };
    turn_.unlock();
    const Again again{turn_};
    return f();
  }

 private:
  std::unique_lock<std::recursive_mutex> turn_;
};

}  // namespace bipot
