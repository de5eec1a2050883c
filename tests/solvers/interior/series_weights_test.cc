#include "solvers/interior/series_weights.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

constexpr int kOrder = 15;

/// The columns 1 ... n of z, times length^k.
Eigen::MatrixXd scaled(const Eigen::MatrixXd& z, double length) {
  Eigen::MatrixXd terms(z.rows(), kOrder);
  for (int k = 1; k <= kOrder; ++k) terms.col(k - 1) = z.col(k) * std::pow(length, k);
  return terms;
}

TEST(SeriesWeights, AreThePowersBeforeAFit) {
  const SeriesWeights::At at = SeriesWeights(3).at(0.5);
  EXPECT_TRUE(at.regular);
  EXPECT_EQ(at.value, (Vector(4) << 1, 0.5, 0.25, 0.125).finished());
  EXPECT_EQ(at.slope, (Vector(4) << 0, 1, 1, 0.75).finished());  // k alpha^(k-1)
}

TEST(SeriesWeights, FindTheCommonPolesOfAllComponents) {
  // 1 / (1 - alpha / p) = sum_k (alpha / p)^k for ten poles p, as many as the denominator has. At
  // alpha = 3/2, beyond the radius of convergence, the powers of the pole -1 grow as 1.5^k.
  const double pole[] = {-1, -1.2, -1.5, -2, -3, -6, 2, 2.5, 4, 8};
  const double alpha = 1.5;
  Eigen::MatrixXd z(10, kOrder + 1);
  for (int i = 0; i < 10; ++i) {
    for (int k = 0; k <= kOrder; ++k) z(i, k) = std::pow(pole[i], -k);
  }
  SeriesWeights weights(kOrder);
  EXPECT_GT(std::abs(z.row(0).dot(weights.at(alpha).value)), 100);
  weights.fit(scaled(z, 1), 1);
  const SeriesWeights::At at = weights.at(alpha);
  ASSERT_TRUE(at.regular);
  for (int i = 0; i < 10; ++i) {
    const double sum = 1 / (1 - alpha / pole[i]);
    EXPECT_NEAR(z.row(i).dot(at.value), sum, 1e-6 * sum) << pole[i];
    EXPECT_NEAR(z.row(i).dot(at.slope), sum * sum / pole[i], 1e-5 * sum * sum) << pole[i];
  }
}

TEST(SeriesWeights, AreMoreAccurateThanTaylorsPolynomialNearAFold) {
  // (1 - alpha)^q, which have a branch point at alpha = 1: z_k = z_(k-1) (k - 1 - q) / k.
  const double q[] = {0.5, 1.5, 2.5, 0.25, 0.75, 1.25};
  const double alpha = 0.95;
  Eigen::MatrixXd z = Eigen::MatrixXd::Ones(6, kOrder + 1);
  Vector exact(6);
  for (int i = 0; i < 6; ++i) {
    for (int k = 1; k <= kOrder; ++k) z(i, k) = z(i, k - 1) * (k - 1 - q[i]) / k;
    exact[i] = std::pow(1 - alpha, q[i]);
  }
  SeriesWeights weights(kOrder);
  const double taylor = (z * weights.at(alpha).value - exact).norm();
  weights.fit(scaled(z, 0.5), 0.5);
  EXPECT_LT((z * weights.at(alpha).value - exact).norm(), 0.1 * taylor);
}

TEST(SeriesWeights, SlopesAreDerivativesOfTheWeights) {
  Eigen::MatrixXd z(2, kOrder + 1);  // log(1 + alpha), exp(alpha)
  z.col(0) << 0, 1;
  for (int k = 1; k <= kOrder; ++k) {
    z(0, k) = -std::pow(-1, k) / k;
    z(1, k) = z(1, k - 1) / k;
  }
  SeriesWeights weights(kOrder);
  weights.fit(scaled(z, 0.8), 0.8);
  const double alpha = 1.2, h = 1e-5;
  const Vector difference = (weights.at(alpha + h).value - weights.at(alpha - h).value) / (2 * h);
  // The error of the difference is h²/6 times the third derivative.
  EXPECT_LT((weights.at(alpha).slope - difference).norm(), 1e-5 * difference.norm());
  EXPECT_EQ(weights.at(alpha).value[0], 1);
}

TEST(SeriesWeights, TellAPolePassed) {
  // 1 / (1 - alpha): the denominator changes its sign at 1.
  const Eigen::MatrixXd z = Eigen::MatrixXd::Ones(1, kOrder + 1);
  SeriesWeights weights(kOrder);
  weights.fit(scaled(z, 0.5), 0.5);
  EXPECT_TRUE(weights.at(0.9).regular);
  EXPECT_FALSE(weights.at(1.1).regular);
}

TEST(SeriesWeights, TheLowestOrdersCanBeFitted) {
  for (const int order : {2, 3, 4}) {
    SeriesWeights weights(order);
    weights.fit(Eigen::MatrixXd::Ones(1, order), 1);
    EXPECT_NEAR(weights.at(0.5).value.sum(), 2, 1e-12) << order;  // 1 / (1 - alpha)
  }
}

}  // namespace
}  // namespace bipot
