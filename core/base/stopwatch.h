#pragma once

#include <chrono>

namespace bipot {

/// Wall clock.
class Stopwatch {
 public:
  /// Seconds since construction.
  double seconds() const { return between(start_, Clock::now()); }
  /// Seconds since construction or the last lap.
  double lap() {
    const Clock::time_point now = Clock::now();
    const double seconds = between(last_, now);
    last_ = now;
    return seconds;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static double between(Clock::time_point from, Clock::time_point to) {
    return std::chrono::duration<double>(to - from).count();
  }
  Clock::time_point start_ = Clock::now(), last_ = start_;
};

}  // namespace bipot
