#pragma once

#include <algorithm>

namespace bipot {

/// Chooses between one thread and all for repeated work, by its measured times. Threads that wait
/// for each other often are much slower than one thread if other processes occupy the cores.
class QuickerTeam {
 public:
  explicit QuickerTeam(int threads) : threads_(threads) {}

  /// Number of threads for the next run.
  int threads() const { return alone_now_ ? 1 : threads_; }
  /// Records the time of that run.
  void took(double seconds) {
    if (threads_ == 1) return;
    double& time = alone_now_ ? alone_ : team_;
    if (time >= 0 && begins_ > 0) {
      time = std::min(time, seconds);
    } else {
      time = time < 0 || trying_ ? seconds : kMemory * time + (1 - kMemory) * seconds;
    }
    ++runs_;
    if (begins_ > 0) {
      --begins_;
      alone_now_ = false;
      trying_ = true;
      if (begins_ > 0) return;
    }
    const bool alone_before = alone_now_;
    alone_now_ = alone_ <= team_;
    if (trying_) {
      // The alternative was tried: less often if that was in vain.
      pause_ = alone_now_ == alone_before ? kShortestPause : 2 * pause_;
      trying_ = false;
      runs_ = 0;
    } else if (runs_ >= pause_) {
      alone_now_ = !alone_now_;
      trying_ = true;
    }
  }

 private:
  static constexpr double kMemory = 0.75;
  static constexpr int kShortestPause = 32;
  int threads_;
  int begins_ = 4;  // runs of the beginning: one alone, then some of the team, whose threads start
  bool alone_now_ = true, trying_ = false;
  double alone_ = -1, team_ = -1;
  int runs_ = 0, pause_ = kShortestPause;
};

}  // namespace bipot
