#include "bench/measure/cpu_limit.h"

#include <algorithm>

#include "bench/measure/stopwatch.h"

namespace bipot {

CpuLimit::CpuLimit(double seconds)
    : end_(cpu_seconds() + seconds),
      grain_(std::min(1e-3, seconds / 20)),
      asked_(Clock::now()),
      read_(asked_) {}

bool CpuLimit::operator()() {
  // Iterations may take a microsecond or a second, in any order. A few quick calls pass unchecked.
  // Then the wall clock, which is cheap to read, decides whether to ask the system for the CPU
  // time.
  if (reached_ || ++calls_ < stride_) return reached_;
  calls_ = 0;
  const Clock::time_point now = Clock::now();
  const auto since = [now](Clock::time_point then) {
    return std::chrono::duration<double>(now - then).count();
  };
  stride_ = since(asked_) < grain_ ? 8 : 1;
  asked_ = now;
  if (since(read_) < grain_) return false;
  read_ = now;
  reached_ = cpu_seconds() >= end_;
  return reached_;
}

}  // namespace bipot
