#pragma once

#include <chrono>

namespace bipot {

/// A limit on CPU time for inner loops: other work on the machine must not change the result of a
/// solver. It asks the system once in a millisecond at most.
class CpuLimit {
 public:
  /// Counts from construction. `seconds` > 0.
  explicit CpuLimit(double seconds);
  bool operator()();
  /// True if a call has reported the limit.
  bool reached() const { return reached_; }

  /// Limit on wall time, relative to the CPU limit, for loops that do not call this.
  static constexpr double kWallFactor = 20;

 private:
  using Clock = std::chrono::steady_clock;
  double end_, grain_;
  Clock::time_point asked_, read_;
  int stride_ = 1, calls_ = 0;
  bool reached_ = false;
};

}  // namespace bipot
