#pragma once

#include <cmath>
#include <cstdint>
#include <random>

namespace bipot {

/// Portable draws: the standard fixes its engines, not its distributions.
class RandomDraw {
 public:
  /// A stream of its own for each index of a set.
  RandomDraw(std::uint64_t seed, std::uint64_t index) {
    std::seed_seq mix{seed & 0xffffffffu, seed >> 32, index & 0xffffffffu, index >> 32};
    engine_.seed(mix);
  }
  /// In [0, 1).
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }
  double between(double low, double high) { return low + (high - low) * uniform(); }
  /// 10 to the power of a number between these.
  double decades(double low, double high) { return std::pow(10.0, between(low, high)); }
  int below(int n) { return static_cast<int>(engine_() % static_cast<unsigned>(n)); }
  bool chance(double p) { return uniform() < p; }

 private:
  std::mt19937_64 engine_;
};

}  // namespace bipot
