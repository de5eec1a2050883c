#pragma once

#include "core/base/stopwatch.h"  // time on the wall

namespace bipot {

/// CPU time of this process so far [s].
inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// CPU time of this process since construction, independent of other work on the machine.
class CpuStopwatch {
 public:
  double seconds() const { return cpu_seconds() - start_; }

 private:
  double start_ = cpu_seconds();
};

}  // namespace bipot
