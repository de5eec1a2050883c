#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "core/scene/generators.h"

namespace bipot {

/// The standard fixes the engine's output, not its distributions: these are ours.
class PortableRandom {
 public:
  explicit PortableRandom(std::uint64_t seed) : engine_(seed) {}
  /// In [0, 1), 53 random bits.
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }
  /// In [0, n), without bias.
  std::uint64_t below(std::uint64_t n) {
    const std::uint64_t limit = engine_.max() - engine_.max() % n;
    std::uint64_t x = engine_();
    while (x >= limit) x = engine_();
    return x % n;
  }

 private:
  std::mt19937_64 engine_;
};

/// Throws std::invalid_argument for a count, classes or a spacing that no filling has.
void check_filling(int count, const std::vector<RadiusClass>& classes, double spacing);

/// `count` radii, the classes' shares met by largest remainders, shuffled. Throws
/// std::invalid_argument for classes without sound radii and shares.
std::vector<double> drawn_radii(int count, const std::vector<RadiusClass>& classes,
                                PortableRandom& random);

}  // namespace bipot
