#pragma once

#include <sys/resource.h>

namespace bipot {

/// Largest memory of this process so far, by the system (ru_maxrss). [bytes]
inline double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

}  // namespace bipot
