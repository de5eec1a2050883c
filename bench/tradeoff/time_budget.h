#pragma once

#include <algorithm>

#include "core/base/stopwatch.h"

namespace bipot {

/// The wall time of an advice, and the fractions of it at which stages must be done.
class TimeBudget {
 public:
  static constexpr double kTightRunEnd = 0.06, kRunEnd = 0.25, kStepsEnd = 0.5, kTrialsEnd = 0.75,
                          kLastTrialEnd = 0.8;

  /// Counts from construction; `limit` in seconds.
  explicit TimeBudget(double limit) : limit_(limit) {}
  /// Spent so far [s].
  double seconds() const { return watch_.seconds(); }
  /// Seconds until that part of the limit is spent; never below a millisecond.
  double until(double part) const { return std::max(1e-3, part * limit_ - seconds()); }
  bool past(double part) const { return seconds() >= part * limit_; }

 private:
  Stopwatch watch_;
  double limit_;
};

}  // namespace bipot
