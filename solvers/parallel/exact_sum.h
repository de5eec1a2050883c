#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace bipot {

/// The exact sum of doubles, rounded once at the end: the same bits in any order and any number of
/// parts (Kulisch's long accumulator; Kulisch and Miranker, SIAM Rev. 28, 1986). Digits of 32 bits
/// in 64-bit integers delay carries. Parts are added digit by digit, in parallel with one reduction
/// of integers. 536 bytes; a summand costs three additions.
class ExactSum {
 public:
  ExactSum& operator+=(double x);

  /// For parts on other processes: sum the returned digits over all of them, then call value(). At
  /// most 2^30 processes.
  std::span<std::int64_t> digits();
  /// The sum, rounded to nearest. NaN if a summand was NaN or infinite.
  double value();

  /// 67 for all doubles and carries, and one for NaN and infinity.
  static constexpr int kDigits = 68;

 private:
  void carry();

  std::array<std::int64_t, kDigits> digit_{};
  std::int64_t since_carry_ = 0;
};

}  // namespace bipot
