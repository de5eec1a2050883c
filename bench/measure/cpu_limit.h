#pragma once

#include <chrono>

namespace bipot {

/// A limit on CPU time that can be asked in an inner loop: what else the machine does must not
/// decide how far a solver gets. It looks once a millisecond at most.
class CpuLimit {
 public:
  /// Counts from now. `seconds` > 0.
  explicit CpuLimit(double seconds);
  bool operator()();
  /// Whether it has ever said so.
  bool reached() const { return reached_; }

  /// Solvers have a limit on wall time, too, for loops that do not ask: this many times as long.
  static constexpr double kWallFactor = 20;

 private:
  using Clock = std::chrono::steady_clock;
  double end_, grain_;
  Clock::time_point asked_, read_;
  int stride_ = 1, calls_ = 0;
  bool reached_ = false;
};

}  // namespace bipot
