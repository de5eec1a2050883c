#include "core/linear/sparse_factor.h"

#include <Eigen/Dense>

#include "tests/support/random_vector.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

using Eigen::MatrixXd;

/// Sparse and without structure; `shift` on the diagonal.
MatrixXd random_dense(int n, unsigned seed, double shift) {
  PortableRandom draw(seed);
  MatrixXd A = MatrixXd::Zero(n, n);
  for (int k = 0; k < 4 * n; ++k) A(draw.below(n), draw.below(n)) = draw.symmetric();
  A.diagonal().array() += shift;
  return A;
}

SparseMatrix positive_definite(int n, unsigned seed) {
  const MatrixXd B = random_dense(n, seed, 0.0);
  return MatrixXd(B * B.transpose() + MatrixXd::Identity(n, n)).sparseView();
}

TEST(SparseCholesky, SolvesForVectorsAndSparseMatrices) {
  const SparseMatrix A = positive_definite(60, 1);
  SparseCholesky factor;
  ASSERT_TRUE(factor.factor(A));
  const Vector x = random_vector(60, 2);
  EXPECT_LT((factor.solve(Vector(A * x)) - x).norm(), 1e-12 * x.norm());
  const SparseMatrix B = random_dense(60, 3, 0.0).leftCols(7).sparseView();
  EXPECT_LT((MatrixXd(A * factor.solve(B)) - MatrixXd(B)).norm(), 1e-12 * B.norm());
}

TEST(SparseCholesky, FactorsAgainWithOtherValuesAndOtherPatterns) {
  SparseMatrix A = positive_definite(40, 1);
  SparseCholesky factor;
  ASSERT_TRUE(factor.factor(A));
  const Vector x = random_vector(40, 2);
  A.diagonal() *= 3;
  ASSERT_TRUE(factor.factor(A));
  EXPECT_LT((factor.solve(Vector(A * x)) - x).norm(), 1e-12);
  const SparseMatrix other = positive_definite(40, 5);
  ASSERT_TRUE(factor.factor(other));
  EXPECT_LT((factor.solve(Vector(other * x)) - x).norm(), 1e-12);
  const SparseMatrix smaller = positive_definite(11, 6);
  ASSERT_TRUE(factor.factor(smaller));
  const Vector y = random_vector(11, 2);
  EXPECT_LT((factor.solve(Vector(smaller * y)) - y).norm(), 1e-12);
}

TEST(SparseCholesky, RefusesIndefiniteSingularAndNonFiniteMatricesAndRecovers) {
  SparseMatrix A = positive_definite(40, 1);
  const SparseMatrix good = A;
  SparseCholesky factor;
  ASSERT_TRUE(factor.factor(A));
  A.coeffRef(7, 7) = -1;
  EXPECT_FALSE(factor.factor(A));
  EXPECT_THROW(factor.solve(random_vector(40, 2)), std::logic_error);
  A.coeffRef(7, 7) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(factor.factor(A));
  const SparseMatrix singular = MatrixXd::Ones(3, 3).sparseView();
  EXPECT_FALSE(factor.factor(singular));
  ASSERT_TRUE(factor.factor(good));
  const Vector x = random_vector(40, 2);
  EXPECT_LT((factor.solve(Vector(good * x)) - x).norm(), 1e-12);
}

TEST(SparseLU, SolvesUnsymmetricSystemsWithEveryStrategy) {
  const SparseMatrix A = random_dense(80, 1, 3).sparseView();
  const Vector x = random_vector(80, 2);
  for (const auto strategy : {SparseLU::Strategy::kAuto, SparseLU::Strategy::kSymmetric,
                              SparseLU::Strategy::kUnsymmetric}) {
    SparseLU factor(strategy);
    ASSERT_TRUE(factor.factor(A));
    for (int refinements : {0, 2}) {
      EXPECT_LT((factor.solve(Vector(A * x), refinements) - x).norm(), 1e-11 * x.norm());
    }
  }
}

TEST(SparseLU, KnowsTheSignOfTheDeterminant) {
  SparseLU factor;
  int positive = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const MatrixXd A = random_dense(12, seed, 0.7);
    const double determinant = A.determinant();
    if (std::abs(determinant) < 1e-6) continue;
    ASSERT_TRUE(factor.factor(A.sparseView()));
    EXPECT_EQ(factor.determinant_sign(), determinant > 0 ? 1 : -1) << "seed " << seed;
    positive += determinant > 0;
  }
  EXPECT_GT(positive, 5);
  EXPECT_LT(positive, 35);
  // Beyond the range of a double: 1e-3^200.
  SparseMatrix tiny(201, 201);
  tiny.setIdentity();
  tiny *= -1e-3;
  ASSERT_TRUE(factor.factor(tiny));
  EXPECT_EQ(factor.determinant_sign(), -1);
}

TEST(SparseLU, RefusesSingularMatricesAndRecovers) {
  SparseLU factor;
  MatrixXd A = random_dense(20, 1, 3);
  const SparseMatrix good = A.sparseView();
  ASSERT_TRUE(factor.factor(good));
  A.row(4).setZero();
  EXPECT_FALSE(factor.factor(A.sparseView()));
  EXPECT_FALSE(factor.factor(MatrixXd::Ones(3, 3).sparseView()));
  ASSERT_TRUE(factor.factor(good));
  const Vector x = random_vector(20, 2);
  EXPECT_LT((factor.solve(Vector(good * x)) - x).norm(), 1e-12);
}

TEST(SparseLU, RefusesToSolveWithoutAFactor) {
  EXPECT_THROW(SparseLU().solve(random_vector(3, 1)), std::logic_error);
  EXPECT_THROW(SparseLU().determinant_sign(), std::logic_error);
  SparseLU factor;
  ASSERT_FALSE(factor.factor(MatrixXd::Ones(3, 3).sparseView()));
  EXPECT_THROW(factor.solve(random_vector(3, 1)), std::logic_error);
}

}  // namespace
}  // namespace bipot
