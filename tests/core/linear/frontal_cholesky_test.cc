#include "core/linear/frontal_cholesky.h"

#include "tests/support/full_matrix.h"
#include "tests/support/grid_matrix.h"
#include "tests/support/random_vector.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// B Bᵀ + 1 of a grid without symmetry: couples nodes two apart.
SparseMatrix positive_definite_grid(int side, int block, unsigned seed) {
  const SparseMatrix B = grid_matrix(side, block, seed, 2);
  SparseMatrix one(B.cols(), B.cols());
  one.setIdentity();
  const SparseMatrix transposed = B.transpose();
  return SparseMatrix(B * transposed) + one;
}

void expect_solves(const FrontalCholesky& factor, const SparseMatrix& A) {
  const int n = static_cast<int>(A.cols());
  const Vector x = random_vector(n, 2);
  // The condition is below 1e4: entries of B are at most 3, some thirty a row. One solve has single
  // precision, each correction takes as much off the error, whatever the units are.
  for (const double unit : {1.0, 1e-60}) {
    Vector found = Vector::Zero(n);
    for (const double error : {1e-3, 1e-6, 1e-9, 1e-12}) {
      Vector residual = A * (unit * x - found);
      factor.solve(residual, residual);
      found += residual;
      EXPECT_LT((found - unit * x).norm(), error * unit * x.norm()) << n;
    }
  }
}

/// Sizes from one front to hundreds, with AMD and (the last) with METIS orders; one object for all.
TEST(FrontalCholesky, SolvesWithOtherValuesAndOtherPatterns) {
  FrontalCholesky factor;
  for (const auto& [side, block] : {std::pair{1, 1}, {1, 3}, {2, 3}, {5, 1}, {20, 3}, {66, 1}}) {
    SparseMatrix A = positive_definite_grid(side, block, 7);
    ASSERT_TRUE(factor.factor(A)) << side;
    expect_solves(factor, A);
    EXPECT_GE(2 * factor.num_entries(), to_size(A.nonZeros()));
    for (int j = 0; j < A.cols(); ++j) A.coeffRef(j, j) *= 1 + j % 3;
    ASSERT_TRUE(factor.factor(A)) << side;
    expect_solves(factor, A);
  }
}

/// A front of more columns than are eliminated at once.
TEST(FrontalCholesky, SolvesWithOneLargeFront) {
  const SparseMatrix A = full_matrix(1300);
  FrontalCholesky factor;
  ASSERT_TRUE(factor.factor(A));
  expect_solves(factor, A);
}

TEST(FrontalCholesky, StopsWithinAFrontAndRecovers) {
  const SparseMatrix A = full_matrix(1800);
  int questions = 0, answered = 1;
  FrontalCholesky factor;
  factor.stop_by(FactorStop([&] { return ++questions > answered; }));
  EXPECT_THROW((void)factor.factor(A), FactorStopped);
  EXPECT_EQ(questions, 2);
  Vector x = random_vector(1800, 1);
  EXPECT_THROW(factor.solve(x, x), std::logic_error);
  answered = 1000;
  ASSERT_TRUE(factor.factor(A));
  EXPECT_GT(questions, 4);
  expect_solves(factor, A);
}

/// Rows and columns in units from 1e-40 to 1e40, beyond the range of single precision.
TEST(FrontalCholesky, DoesNotDependOnUnits) {
  SparseMatrix A = positive_definite_grid(20, 3, 7);
  FrontalCholesky factor;
  ASSERT_TRUE(factor.factor(A));
  Vector units(A.cols());
  for (int i = 0; i < units.size(); ++i) units[i] = std::ldexp(1.0, 133 * (i % 3 - 1));
  const Vector b = random_vector(static_cast<int>(A.cols()), 4);
  Vector x, scaled;
  factor.solve(b, x);
  A = units.asDiagonal() * A * units.asDiagonal();
  ASSERT_TRUE(factor.factor(A));
  factor.solve(units.cwiseProduct(b), scaled);
  EXPECT_EQ(scaled, x.cwiseQuotient(units));
}

TEST(FrontalCholesky, RefusesIndefiniteAndNonFiniteMatricesAndRecovers) {
  const SparseMatrix good = positive_definite_grid(12, 2, 3);
  const int n = static_cast<int>(good.cols());
  FrontalCholesky factor;
  Vector x;
  EXPECT_THROW(factor.solve(Vector::Zero(n), x), std::logic_error);
  for (const int k : {0, n / 3, n - 1}) {
    for (const double bad : {-1.0, 0.0, std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity()}) {
      SparseMatrix A = good;
      A.coeffRef(k, k) = bad;
      EXPECT_FALSE(factor.factor(A)) << k << " " << bad;
      EXPECT_THROW(factor.solve(Vector::Zero(n), x), std::logic_error);
    }
    ASSERT_TRUE(factor.factor(good));
    expect_solves(factor, good);
  }
}

TEST(FrontalCholesky, FactorsNoColumnsBeforeAnAnalysis) {
  FrontalCholesky factor;
  EXPECT_THROW((void)factor.factor([](int, const FrontalCholesky::Column&) {}, Vector()),
               std::logic_error);
}

}  // namespace
}  // namespace bipot
