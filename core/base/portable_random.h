#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <random>

namespace bipot {

/// Random numbers that are the same on every platform: the standard fixes the output of its
/// engines, not that of its distributions. Of the 64 bits of an engine, numbers use 53.
template <class Engine>
class RandomNumbers {
 public:
  explicit RandomNumbers(Engine engine) : engine_(engine) {}
  explicit RandomNumbers(std::uint64_t seed) : engine_(seed) {}
  /// A stream of its own for each index of a set.
  RandomNumbers(std::uint64_t seed, std::uint64_t index) {
    std::seed_seq mix{seed & 0xffffffffu, seed >> 32, index & 0xffffffffu, index >> 32};
    engine_.seed(mix);
  }
  /// In [0, 1).
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }
  /// In [-1, 1).
  double symmetric() { return 2 * uniform() - 1; }
  double between(double low, double high) { return low + (high - low) * uniform(); }
  /// 10 to the power of a number between these.
  double decades(double low, double high) { return std::pow(10.0, between(low, high)); }
  bool chance(double probability) { return uniform() < probability; }
  /// In [0, n), n > 0, without bias.
  template <std::integral Number>
  Number below(Number n) {
    const auto range = static_cast<std::uint64_t>(n);
    const std::uint64_t limit = Engine::max() - Engine::max() % range;
    std::uint64_t x = engine_();
    while (x >= limit) x = engine_();
    return static_cast<Number>(x % range);
  }

 private:
  Engine engine_;
};

using PortableRandom = RandomNumbers<std::mt19937_64>;

/// Splitmix64 (Steele, Lea and Flood 2014), started at a mixture of keys: its numbers depend on the
/// keys alone, without a memory.
class KeyedEngine {
 public:
  KeyedEngine(std::initializer_list<int> keys) {
    for (const int key : keys) {
      state_ = (*this)() ^ static_cast<std::uint64_t>(static_cast<std::uint32_t>(key));
    }
    (*this)();
  }
  static constexpr std::uint64_t max() { return UINT64_MAX; }
  std::uint64_t operator()() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15U;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
    return z ^ (z >> 31);
  }

 private:
  std::uint64_t state_ = 0;
};

using KeyedRandom = RandomNumbers<KeyedEngine>;

}  // namespace bipot
