#pragma once

#include <bit>
#include <cstdint>
#include <cstring>

#include "core/base/types.h"

namespace bipot {

/// Hash of the bits of numbers (FNV-1a, 64 bits): one bit more or less changes it.
class BitHash {
 public:
  void add(double value) {
    auto bits = std::bit_cast<std::uint64_t>(value);
    for (int k = 0; k < 8; ++k, bits >>= 8) value_ = (value_ ^ (bits & 0xff)) * 0x100000001b3u;
  }
  void add(const Vector& values) {
    for (const double value : values) add(value);
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

/// Bits, not values: -0 is not 0 and a NaN is itself.
inline bool same_bits(const Vector& a, const Vector& b) {
  return a.size() == b.size() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * to_size(a.size())) == 0;
}

}  // namespace bipot
