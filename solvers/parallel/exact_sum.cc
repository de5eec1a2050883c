#include "solvers/parallel/exact_sum.h"

#include <bit>
#include <cmath>

#include "core/base/types.h"

namespace bipot {
namespace {

__extension__ using Wide = unsigned __int128;

constexpr int kDigitBits = 32;
constexpr std::int64_t kBase = std::int64_t{1} << kDigitBits;
constexpr std::int64_t kLowBits = kBase - 1;
constexpr int kLeast = -1074;                     // exponent of digit 0's lowest bit
constexpr std::int64_t kMostAdditions = 1 << 30;  // each adds less than 2^32 to a digit
constexpr std::size_t kLast = ExactSum::kDigits - 2, kStrange = ExactSum::kDigits - 1;

}  // namespace

ExactSum& ExactSum::operator+=(double x) {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const int exponent = static_cast<int>((bits >> 52) & 0x7ff);
  if (exponent == 0x7ff) {
    digit_[kStrange] = 1;
    return *this;
  }
  std::uint64_t mantissa = bits & ((std::uint64_t{1} << 52) - 1);
  if (exponent != 0) mantissa |= std::uint64_t{1} << 52;
  if (mantissa == 0) return *this;
  const int position = exponent == 0 ? 0 : exponent - 1;  // of the lowest bit, above kLeast
  const std::size_t first = to_size(position / kDigitBits);
  const Wide spread = Wide{mantissa} << (position % kDigitBits);
  const auto low = static_cast<std::int64_t>(spread & Wide{kLowBits});
  const auto middle = static_cast<std::int64_t>((spread >> kDigitBits) & Wide{kLowBits});
  const auto high = static_cast<std::int64_t>(spread >> (2 * kDigitBits));
  if (bits >> 63 != 0) {
    digit_[first] -= low;
    digit_[first + 1] -= middle;
    digit_[first + 2] -= high;
  } else {
    digit_[first] += low;
    digit_[first + 1] += middle;
    digit_[first + 2] += high;
  }
  if (++since_carry_ == kMostAdditions) carry();
  return *this;
}

/// Moves every digit but the last into [0, 2^32).
void ExactSum::carry() {
  std::int64_t over = 0;
  for (std::size_t k = 0; k < kLast; ++k) {
    const std::int64_t sum = digit_[k] + over;
    over = sum >> kDigitBits;  // rounds down, as C++20 promises
    digit_[k] = sum & kLowBits;
  }
  digit_[kLast] += over;
  since_carry_ = 0;
}

std::span<std::int64_t> ExactSum::digits() {
  carry();
  return digit_;
}

double ExactSum::value() {
  if (digit_[kStrange] != 0) return kNaN;
  carry();
  ExactSum size = *this;
  const bool negative = digit_[kLast] < 0;
  if (negative) {
    for (std::size_t k = 0; k <= kLast; ++k) size.digit_[k] = -size.digit_[k];
    size.carry();
  }
  std::size_t top = kLast;
  while (top > 0 && size.digit_[top] == 0) --top;
  // At least 65 bits from the top; the last one records whether lower bits are set.
  Wide head = 0;
  std::size_t next = top + 1;
  int taken = 0;
  for (; next > 0 && taken < 3; --next, ++taken) {
    head = (head << kDigitBits) | static_cast<Wide>(size.digit_[next - 1]);
  }
  bool below = false;
  for (std::size_t k = 0; k < next; ++k) below |= size.digit_[k] != 0;
  if (below) head |= 1;
  const double value =
      std::ldexp(static_cast<double>(head), static_cast<int>(next) * kDigitBits + kLeast);
  return negative ? -value : value;
}

}  // namespace bipot
