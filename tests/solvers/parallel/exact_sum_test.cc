// The long accumulator against sums that are known exactly.

#include "solvers/parallel/exact_sum.h"

#include <bit>

#include "core/base/types.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

double exact(const std::vector<double>& x) {
  ExactSum sum;
  for (const double v : x) sum += v;
  return sum.value();
}

TEST(ExactSum, OneSummandIsItself) {
  constexpr double kTiny = std::numeric_limits<double>::denorm_min();
  for (const double x : {0.0, 1.0, -1.0, 0.1, -3.7e300, 1.7976931348623157e308, kTiny, -kTiny,
                         2.2250738585072014e-308, 4.9e-310}) {
    EXPECT_EQ(exact({x}), x);
  }
  std::mt19937_64 engine(3);
  for (int k = 0; k < 10000; ++k) {
    const double x = std::bit_cast<double>(engine());
    if (!std::isfinite(x)) continue;
    EXPECT_EQ(exact({x}), x);
  }
}

TEST(ExactSum, CancellationLeavesWhatIsThere) {
  EXPECT_EQ(exact({1e300, 1.0, -1e300}), 1.0);
  EXPECT_EQ(exact({1e16, 1.0, 1.0, -1e16}), 2.0);
  EXPECT_EQ(exact({-1e-300, 1e300, -1e300}), -1e-300);
  EXPECT_EQ(exact({0.1, 0.2, -0.3}), 0x1p-55);  // the doubles nearest to these add up to 2^-55
  EXPECT_EQ(exact({1e308, 1e308, -1e308}), 1e308);
}

TEST(ExactSum, IsRoundedOnceToNearest) {
  // 1 + 2^-53 is half way between two doubles: to even. Anything more goes up.
  EXPECT_EQ(exact({1.0, 0x1p-53}), 1.0);
  EXPECT_EQ(exact({1.0, 0x1p-53, 0x1p-1000}), 1.0 + 0x1p-52);
  EXPECT_EQ(exact({-1.0, -0x1p-53, -0x1p-1000}), -1.0 - 0x1p-52);
}

TEST(ExactSum, OrderAndPartsDoNotMatter) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> mantissa(-1, 1), exponent(-60, 60);
  std::vector<double> x(20000);
  for (double& v : x) v = std::ldexp(mantissa(engine), static_cast<int>(exponent(engine)));
  const double whole = exact(x);
  long double reference = 0;
  double size = 0;
  for (const double v : x) {
    reference += v;
    size += std::abs(v);
  }
  EXPECT_NEAR(whole, static_cast<double>(reference), 1e-18 * size);
  for (int shuffle = 0; shuffle < 5; ++shuffle) {
    std::shuffle(x.begin(), x.end(), engine);
    EXPECT_EQ(exact(x), whole);
    // Three parts, their digits added as processes do.
    ExactSum part[3];
    for (std::size_t k = 0; k < x.size(); ++k) part[k % 7 % 3] += x[k];
    const auto total = part[0].digits();
    for (int k = 1; k < 3; ++k) {
      const auto digits = part[k].digits();
      for (std::size_t i = 0; i < total.size(); ++i) total[i] += digits[i];
    }
    EXPECT_EQ(part[0].value(), whole);
  }
  // Plain sums of other orders differ: the test would see an order.
  std::sort(x.begin(), x.end());
  double up = 0, down = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    up += x[k];
    down += x[x.size() - 1 - k];
  }
  EXPECT_NE(up, down);
}

TEST(ExactSum, WhatIsNoNumberIsKept) {
  EXPECT_TRUE(std::isnan(exact({1.0, kNaN})));
  EXPECT_TRUE(std::isnan(exact({kInfinity, -kInfinity})));
}

}  // namespace
}  // namespace bipot
