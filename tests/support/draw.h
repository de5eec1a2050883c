#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "core/base/types.h"

namespace bipot {

/// Portable random draws for tests: the standard fixes its engines, not its distributions.
class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}
  /// In [0, 1).
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }
  /// In [-1, 1).
  double symmetric() { return 2 * uniform() - 1; }
  double between(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform in the logarithm.
  double log_between(double low, double high) { return low * std::pow(high / low, uniform()); }
  int below(int n) { return static_cast<int>(engine_() % static_cast<unsigned>(n)); }

 private:
  std::mt19937_64 engine_;
};

/// Numbers in [-1, 1).
inline Vector random_vector(Eigen::Index size, unsigned seed) {
  Draw draw(seed);
  Vector x(size);
  for (double& value : x) value = draw.symmetric();
  return x;
}

}  // namespace bipot
