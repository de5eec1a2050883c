#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "core/scene/generators.h"

namespace bipot {

/// Random numbers with the same bits on every platform. The C++ standard fixes the output of its
/// engine, but not its distributions.
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

/// Throws std::invalid_argument for a count, classes or a spacing that no filling can have.
void check_filling(int count, const std::vector<RadiusClass>& classes, double spacing);

/// `count` radii in random order, whose numbers per class follow by largest remainders. Throws
/// std::invalid_argument for classes without sound radii and shares.
std::vector<double> drawn_radii(int count, const std::vector<RadiusClass>& classes,
                                PortableRandom& random);

}  // namespace bipot
