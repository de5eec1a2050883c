#include "solvers/homotopy/ratio_test.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// One after the other, as PathFollower takes the nearest one.
bool nearer_by_definition(const std::vector<double>& bound, const std::vector<double>& value,
                          const std::vector<double>& x, double direction, double step) {
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double speed = bound[k] * x[k] * direction;
    if (speed > 0 && std::max(bound[k] * value[k], 0.0) < step * speed) return true;
  }
  return false;
}

TEST(RatioTest, FindsWhatTheDefinitionFinds) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int found = 0, tried = 0;
  for (int n = 0; n <= 19; ++n) {
    for (int k = 0; k < 300; ++k) {
      std::vector<double> bound(static_cast<std::size_t>(n)), value = bound, x = bound;
      for (std::size_t i = 0; i < x.size(); ++i) {
        bound[i] = static_cast<int>(engine() % 3) - 1;
        value[i] = uniform(engine);
        x[i] = engine() % 4 == 0 ? 0 : uniform(engine);
      }
      const double direction = k % 2 == 0 ? 1 : -1;
      for (const double step : {0.0, 1e-3, 0.02, kInfinity}) {
        const bool nearer = any_nearer(bound.data(), value.data(), x.data(), direction, step, n);
        EXPECT_EQ(nearer, nearer_by_definition(bound, value, x, direction, step))
            << n << ' ' << step;
        found += nearer;
        ++tried;
      }
    }
  }
  EXPECT_GT(found, tried / 10);
  EXPECT_LT(found, tried * 9 / 10);
}

// An infinite step times a speed of 0 is not a number, and blocks nothing.
TEST(RatioTest, WhatDoesNotMoveBlocksNothing) {
  const std::vector<double> one(8, 1.0), zero(8, 0.0);
  EXPECT_FALSE(any_nearer(one.data(), zero.data(), zero.data(), 1, kInfinity, 8));
  EXPECT_TRUE(any_nearer(one.data(), zero.data(), one.data(), 1, kInfinity, 8));
  EXPECT_FALSE(any_nearer(one.data(), zero.data(), one.data(), -1, kInfinity, 8));
}

}  // namespace
}  // namespace bipot
