#include "core/linear/dense_factor.h"

#include "tests/support/test.h"

namespace bipot {
namespace {

TEST(DenseLu, SolvesAndInvertsWithExchangedRows) {
  // The first pivot is zero: rows must be exchanged. [0 2; 4 1] x = (2, 9) has x = (2, 1); the
  // inverse is [-1/8 1/4; 1/2 0].
  Eigen::MatrixXd A(2, 2);
  A << 0, 2, 4, 1;
  const DenseLu lu(A);
  ASSERT_TRUE(lu.ok());
  EXPECT_LT((lu.solve(Vec2(2, 9)) - Vec2(2, 1)).norm(), 1e-15);
  Eigen::MatrixXd inverse(2, 2);
  inverse << -0.125, 0.25, 0.5, 0;
  EXPECT_LT((lu.inverse() - inverse).norm(), 1e-15);
  // |A| = max(4, 3) = 4 and |A⁻¹| = max(1/8 + 1/2, 1/4) = 5/8: 1 / 2.5.
  EXPECT_NEAR(lu.reciprocal_condition(), 0.4, 1e-15);
}

TEST(DenseLu, SaysWhereThereIsNothingToSolve) {
  EXPECT_FALSE(DenseLu(Eigen::MatrixXd::Zero(3, 3)).ok());
  Eigen::MatrixXd bad = Eigen::MatrixXd::Identity(3, 3);
  bad(1, 2) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(DenseLu(bad).ok());
  EXPECT_FALSE(DenseLu(Eigen::MatrixXd(0, 0)).ok());
}

TEST(LeastNormSolution, OfAllWithTheLeastResidualTheSmallest) {
  // Both rows ask x1 + x2 = 2 and 4: the least residual has x1 + x2 = 3, the smallest is (3/2,
  // 3/2).
  Eigen::MatrixXd A(2, 2);
  A << 1, 1, 1, 1;
  EXPECT_LT((least_norm_solution(A, Vec2(2, 4), 1e-12) - Vec2(1.5, 1.5)).norm(), 1e-14);
  // One row, three unknowns: (1, 2, 2) x = 9 is met closest to zero by (1, 2, 2).
  Eigen::MatrixXd row(1, 3);
  row << 1, 2, 2;
  EXPECT_LT((least_norm_solution(row, Vector::Constant(1, 9), 1e-12) - Vec3(1, 2, 2)).norm(),
            1e-14);
}

TEST(NumericalRank, CountsPivotsAboveTheThreshold) {
  const Eigen::MatrixXd A = Eigen::Vector4d(1, 1e-3, 1e-9, 0).asDiagonal();
  EXPECT_EQ(numerical_rank(A, 1e-6), 2);
  EXPECT_EQ(numerical_rank(A, 1e-12), 3);
  EXPECT_EQ(numerical_rank(Eigen::MatrixXd::Ones(3, 5), 1e-10), 1);
  EXPECT_EQ(numerical_rank(Eigen::MatrixXd::Zero(3, 2), 1e-10), 0);
}

TEST(SmallestEigenvalue, OfAChainOfSprings) {
  // 2 on the diagonal, -1 beside it: 2 - 2 cos(pi k / (n + 1)), k = 1 to n. Read below it alone.
  Eigen::MatrixXd A = 2 * Eigen::MatrixXd::Identity(4, 4);
  A.diagonal(-1).setConstant(-1);
  A.diagonal(1).setConstant(7);
  EXPECT_NEAR(smallest_eigenvalue(A), 2 - 2 * std::cos(std::numbers::pi / 5), 1e-14);
}

TEST(LeastNorm, DecompositionsOfARowTwice) {
  // Rows (3, 4) and (6, 8): x of A x = (5, 10) closest to zero is (3, 4) / 5, the rank 1. The
  // pseudo-inverse is the transpose over 125, the sum of squares; Aᵀ (2, -1) = 0.
  Eigen::MatrixXd A(2, 2);
  A << 3, 4, 6, 8;
  const auto [x, rank] = least_norm_and_rank(A, Vec2(5, 10), 1e-12);
  EXPECT_LT((x - Vec2(0.6, 0.8)).norm(), 1e-14);
  EXPECT_EQ(rank, 1);
  const Eigen::MatrixXd both = Vec2(5, 10) * Eigen::RowVector2d(1, -2);
  const Eigen::MatrixXd columns = Vec2(0.6, 0.8) * Eigen::RowVector2d(1, -2);
  EXPECT_LT((least_norm_columns(A, both, 1e-12) - columns).norm(), 1e-14);
  const auto [inverse, left] = inverse_and_left_null_space(A, 1e-12);
  EXPECT_LT((inverse - A.transpose() / 125).norm(), 1e-15);
  ASSERT_EQ(left.cols(), 1);
  EXPECT_NEAR(std::abs(left.col(0).dot(Vec2(2, -1))), std::sqrt(5.0), 1e-14);
}

}  // namespace
}  // namespace bipot
