#pragma once

#include <chrono>
#include <ctime>

namespace bipot {

/// CPU time of this process so far [s].
inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Time on the wall since it was made.
class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// CPU time of this process since it was made: what else the machine does is not counted.
class CpuStopwatch {
 public:
  double seconds() const { return cpu_seconds() - start_; }

 private:
  double start_ = cpu_seconds();
};

}  // namespace bipot
