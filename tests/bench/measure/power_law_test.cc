#include "bench/measure/power_law.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/types.h"

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

}  // namespace
}  // namespace bipot
