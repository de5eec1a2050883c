#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace bipot {

/// The exact sum of doubles, rounded once at the end: the same bits in whatever order and in however
/// many parts it is taken (Kulisch's long accumulator; Kulisch and Miranker, SIAM Rev. 28, 1986).
/// Digits of 32 bits in 64-bit integers, so that carries wait: parts are added digit by digit, with
/// one reduction of integers for several processes. 536 bytes; a summand costs three additions.
class ExactSum {
 public:
  ExactSum& operator+=(double x);

  /// Adds parts that lie on other processes: sum what this returns over all of them, then value().
  /// At most 2^30 processes.
  std::span<std::int64_t> digits();
  /// The sum, rounded to nearest. NaN where a summand was NaN or infinite.
  double value();

  static constexpr int kDigits = 68;  ///< 67 for all doubles and carries, and one for what is none

 private:
  void carry();

  std::array<std::int64_t, kDigits> digit_{};
  std::int64_t since_carry_ = 0;
};

}  // namespace bipot
