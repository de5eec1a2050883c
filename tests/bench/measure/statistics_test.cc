#include "bench/measure/statistics.h"

#include "core/base/types.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(PowerLaw, StudentTAgreesWithTheTables) {
  EXPECT_NEAR(student_t(0.95, 1), 12.7062, 1e-4);
  EXPECT_NEAR(student_t(0.95, 2), 4.30265, 1e-5);
  EXPECT_NEAR(student_t(0.95, 10), 2.22814, 1e-5);
  EXPECT_NEAR(student_t(0.99, 5), 4.03214, 1e-5);
}

TEST(PowerLaw, ExactPowersAreFoundWithoutUncertainty) {
  const PowerLaw law = fit_power_law({10, 100, 1000, 1e4}, {3 * 10, 3 * 100, 3 * 1000, 3e4});
  EXPECT_NEAR(law.exponent, 1, 1e-13);
  EXPECT_NEAR(law.prefactor, 3, 1e-12);
  EXPECT_NEAR(law.confidence, 0, 1e-6);
  EXPECT_EQ(law.points, 4);
}

TEST(PowerLaw, ConfidenceFollowsTheScatter) {
  // ln x = -1, 0, 1, ln y = -1 + d, -2d, 1 + d: slope 1, residual sum of squares 6 d², S_aa = 2, so
  // the half width is t(0.95, 1) sqrt(6 d² / 1 / 2) = 12.7062 sqrt(3) d.
  const double d = 0.01;
  const PowerLaw law = fit_power_law({std::exp(-1), 1, std::exp(1)},
                                     {std::exp(-1 + d), std::exp(-2 * d), std::exp(1 + d)});
  EXPECT_NEAR(law.exponent, 1, 1e-12);
  EXPECT_NEAR(law.confidence, 12.7062 * std::sqrt(3.0) * d, 1e-5);
}

TEST(PowerLaw, WhatCannotBeFittedIsUndefined) {
  EXPECT_TRUE(std::isnan(fit_power_law({10}, {1}).exponent));
  EXPECT_TRUE(std::isnan(fit_power_law({10, 10}, {1, 2}).exponent));
  EXPECT_TRUE(std::isnan(fit_power_law({10, 20}, {1, 2}).confidence));
  const double nan = kNaN;
  EXPECT_EQ(fit_power_law({10, 20, 30, 40}, {1, nan, 0, -1}).points, 1);
}

TEST(MeanValue, HasStudentsConfidence) {
  const MeanValue value = mean_value(std::vector<double>{1, 2, 3});
  EXPECT_DOUBLE_EQ(value.mean, 2);
  EXPECT_NEAR(value.confidence, 4.302653 / std::sqrt(3.0), 1e-5);  // t(2), standard deviation 1
  EXPECT_TRUE(std::isnan(mean_value(std::vector<double>{5}).confidence));
  EXPECT_TRUE(std::isnan(mean_value({}).mean));
}

TEST(ExponentialTail, IsFittedByTheMeanExcess) {
  const ExponentialTail tail = fit_exponential_tail({0.2, 1.0, 1.5, 2.0, 3.5}, 1.0);
  EXPECT_EQ(tail.points, 4);
  EXPECT_DOUBLE_EQ(tail.rate, 1.0);  // excesses 0, 0.5, 1, 2.5
  EXPECT_DOUBLE_EQ(tail.confidence, 1.96 / 2);
  // At the third, 1 - 1/e = 0.632 against steps from 0.5 to 0.75; at the second 0.393 against 0.25
  // to 0.5; at the last 0.918 against 0.75 to 1; at the first 0 against 0 to 0.25: the largest.
  EXPECT_DOUBLE_EQ(tail.distance, 0.25);
  EXPECT_TRUE(std::isnan(fit_exponential_tail({1, 2}, 3).rate));
  EXPECT_TRUE(std::isnan(fit_exponential_tail({1}, 1).rate));
}

TEST(ExponentialTail, FindsTheRateOfDrawnNumbersAndTellsOtherDistributions) {
  std::mt19937_64 engine(4);
  std::vector<double> exponential, uniform;
  for (int k = 0; k < 4000; ++k) {
    const double u = (static_cast<double>(engine() >> 11) + 0.5) * 0x1.0p-53;
    exponential.push_back(-std::log(u) / 1.7);
    uniform.push_back(4 * u);
  }
  const ExponentialTail tail = fit_exponential_tail(exponential, 0.5);
  EXPECT_NEAR(tail.rate, 1.7, 2 * tail.confidence);
  EXPECT_LT(tail.distance, 1.094 / std::sqrt(tail.points));
  EXPECT_GT(fit_exponential_tail(uniform, 0.5).distance, 0.1);
}

TEST(Median, LiesBetweenBothMiddleValues) {
  EXPECT_EQ(sorted_median(std::vector<double>{1, 2, 4, 9}), 3);
  EXPECT_EQ(sorted_median(std::vector<double>{1, 2, kInfinity}), 2);
  EXPECT_EQ(sorted_median(std::vector<double>{1, 2, kInfinity, kInfinity}), kInfinity);
  EXPECT_TRUE(std::isnan(sorted_median({})));
}

// Of 1 to 10 the nearest rank of q is the ceiling of 10 q; the least value for q = 0.
TEST(Quantile, IsTheNearestRank) {
  const std::vector<double> x = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  EXPECT_EQ(quantile(x, 0), 1);
  EXPECT_EQ(quantile(x, 0.1), 1);
  EXPECT_EQ(quantile(x, 0.11), 2);
  EXPECT_EQ(quantile(x, 0.5), 5);
  EXPECT_EQ(quantile(x, 0.9), 9);
  EXPECT_EQ(quantile(x, 1), 10);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

}  // namespace
}  // namespace bipot
