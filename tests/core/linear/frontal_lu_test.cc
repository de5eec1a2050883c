#include "core/linear/frontal_lu.h"

#include <Eigen/Dense>
#include <memory>

#include "core/linear/eight_right_sides.h"
#include "core/linear/frontal_kernels.h"
#include "tests/support/full_matrix.h"
#include "tests/support/grid_matrix.h"
#include "tests/support/random_vector.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// Sizes from one front to hundreds, blocks of one to three: with AMD and with METIS orders.
TEST(FrontalLU, SolvesWithoutSymmetryAndNegativePivots) {
  for (const int side : {1, 2, 5, 20, 40}) {
    for (const int block : {1, 3}) {
      // 3: many leading minors are far from zero, but not dominant and of both signs.
      SparseMatrix A = grid_matrix(side, block, 7, 3);
      for (int j = 0; j < A.cols(); j += 3) A.coeffRef(j, j) -= 6;
      FrontalLU lu;
      ASSERT_TRUE(lu.factor(A)) << side << " " << block;
      const int n = static_cast<int>(A.cols());
      const Vector x = random_vector(n, 2);
      Vector found;
      lu.solve(A * x, found);
      EXPECT_LT((A * found - A * x).norm(), 1e-15 * n * (1 + lu.largest_multiplier()) * x.norm())
          << side << " " << block;
      EXPECT_GE(lu.num_entries(), static_cast<std::size_t>(A.nonZeros()));
    }
  }
}

/// Fronts that such a right side does not reach are passed over: columns of the inverse.
TEST(FrontalLU, SolvesForRightSidesOfOneNumber) {
  const SparseMatrix A = grid_matrix(20, 2, 7, 4);
  FrontalLU lu;
  ASSERT_TRUE(lu.factor(A));
  const int n = static_cast<int>(A.cols());
  Vector found;
  for (int k = 0; k < n; k += 37) {
    const Vector e = Vector::Unit(n, k);
    lu.solve(e, found);
    EXPECT_LT((A * found - e).norm(), 1e-12 * (1 + lu.largest_multiplier()) * found.norm()) << k;
  }
}

/// Right sides of few numbers and of many, as many at once as there are or fewer: each as it is
/// alone, to rounding, and to the bit whatever stands beside it. A front of the root with
/// exchanges.
TEST(FrontalLU, SolvesForSeveralRightSidesAtOnce) {
  for (const int side : {1, 3, 20}) {
    SparseMatrix A = grid_matrix(side, 2, 7, 3);
    for (int j = 0; j < A.cols(); j += 3) A.coeffRef(j, j) -= 6;
    A.coeffRef(0, 0) = A.coeffRef(1, 1) = 0;  // rows are exchanged
    FrontalLU lu;
    ASSERT_TRUE(lu.factor(A)) << side;
    const int n = static_cast<int>(A.cols());
    Vector alone;
    std::array<Vector, kRightSides> first, found;
    for (int count = 1; count <= kRightSides; ++count) {
      FrontalLU::Columns B;
      Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n, count);
      for (int c = 0; c < count; ++c) {
        for (int i = c % n; i < n; i += c % 2 == 0 ? n : 1) {
          right(i, c) = 1 + i + 3 * c;
          B.add(i, right(i, c));
        }
        B.end_column();
      }
      lu.solve(B, found.data());
      for (int c = 0; c < count; ++c) {
        const Vector& x = found[to_size(c)];
        lu.solve(right.col(c), alone);
        EXPECT_LT((x - alone).norm(), 1e-11 * (1 + lu.largest_multiplier()) * alone.norm())
            << side << " " << count << " " << c;
        EXPECT_LT((A * x - right.col(c)).norm(),
                  1e-12 * (1 + lu.largest_multiplier()) * right.col(c).norm() * n);
        if (c == count - 1) first[to_size(c)] = x;
        EXPECT_EQ(x, first[to_size(c)]) << side << " " << count << " " << c;
      }
    }
    FrontalLU::Columns many;
    for (int c = 0; c <= kRightSides; ++c) many.end_column();
    EXPECT_THROW(lu.solve(many, found.data()), std::logic_error);
  }
  const FrontalLU none;
  Vector x;
  EXPECT_THROW(none.solve(FrontalLU::Columns{}, &x), std::logic_error);
}

/// Every length and count up to some beyond the blocks, against plain loops.
TEST(EightRightSides, DoWhatPlainLoopsDo) {
  constexpr int kMost = 19, kStride = 23, kAll = kMost * kRightSides;
  const Vector x = random_vector(kMost * kStride, 3), y = random_vector(kAll, 4);
  const auto at = [](int row, int c) { return row * kRightSides + c; };
  for (int n = 0; n <= kMost; ++n) {
    for (int count = 0; count <= kMost; ++count) {
      Vector out = random_vector(kAll, 5), plain = out;
      subtract_products_of_eight(n, count, x.data(), kStride, y.data(), out.data());
      Vector columns = plain, plain_columns = plain;
      subtract_columns_of_eight(n, count, x.data(), kStride, y.data(), columns.data());
      for (int c = 0; c < kRightSides; ++c) {
        for (int j = 0; j < count; ++j) {
          for (int i = 0; i < n; ++i) {
            plain[at(j, c)] -= x[j * kStride + i] * y[at(i, c)];
            plain_columns[at(i, c)] -= x[j * kStride + i] * y[at(j, c)];
          }
        }
      }
      EXPECT_LT((out - plain).norm(), 1e-13) << n << " " << count;
      EXPECT_LT((columns - plain_columns).norm(), 1e-13) << n << " " << count;
    }
    Vector lower = y, upper = y;
    solve_unit_lower_of_eight(n, x.data(), kStride, lower.data());
    solve_upper_of_eight(n, x.data(), kStride, upper.data());
    for (int c = 0; c < kRightSides; ++c) {
      Vector one(kMost), other(kMost);
      for (int i = 0; i < kMost; ++i) one[i] = other[i] = y[at(i, c)];
      solve_unit_lower(n, x.data(), kStride, one.data());
      solve_upper(n, x.data(), kStride, other.data());
      for (int i = 0; i < kMost; ++i) {
        EXPECT_NEAR(lower[at(i, c)], one[i], 1e-12 * (1 + one.norm())) << n << " " << i;
        EXPECT_NEAR(upper[at(i, c)], other[i], 1e-12 * (1 + other.norm())) << n << " " << i;
      }
    }
  }
}

/// Every length and count up to some beyond the width of the registers, against plain loops.
TEST(FrontalKernels, DoWhatPlainLoopsDo) {
  constexpr int kMost = 21, kStride = 23;
  const Vector x = random_vector(kMost * kStride, 3), y = random_vector(kMost, 4);
  for (int n = 0; n <= kMost; ++n) {
    for (int count = 0; count <= kMost; ++count) {
      Vector out = random_vector(kMost, 5), plain = out;
      subtract_products(n, count, x.data(), kStride, y.data(), out.data());
      for (int j = 0; j < count; ++j) {
        for (int i = 0; i < n; ++i) plain[j] -= x[j * kStride + i] * y[i];
      }
      EXPECT_LT((out - plain).norm(), 1e-14) << n << " " << count;
    }
    Vector lower = y, upper = y, plain = y;
    solve_unit_lower(n, x.data(), kStride, lower.data());
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < i; ++j) plain[i] -= x[j * kStride + i] * plain[j];
    }
    EXPECT_LT((lower - plain).norm(), 1e-13 * plain.norm()) << n;
    solve_upper(n, x.data(), kStride, upper.data());
    for (int i = 0; i < n; ++i) {  // U times it is what it was, the rest is not touched
      double product = 0, size = 0;
      for (int j = i; j < n; ++j) {
        // In place of U's diagonal x has its inverses.
        const double u = j == i ? 1 / x[j * kStride + i] : x[j * kStride + i];
        product += u * upper[j];
        size += std::abs(u * upper[j]);
      }
      EXPECT_NEAR(product, y[i], 1e-14 * size) << n << " " << i;
    }
    for (int i = n; i < kMost; ++i) EXPECT_EQ(upper[i], y[i]);
  }
}

TEST(FrontalLU, KnowsTheSignOfTheDeterminant) {
  int positive = 0, seen = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const SparseMatrix A = grid_matrix(4, 2, seed, 0.5);
    FrontalLU lu;
    if (!lu.factor(A)) continue;
    ++seen;
    // As a product of signs: the determinant of 32 rows is of order one here.
    EXPECT_EQ(lu.determinant_sign(), Eigen::MatrixXd(A).determinant() > 0 ? 1 : -1) << seed;
    positive += lu.determinant_sign() > 0;
  }
  EXPECT_EQ(seen, 40);
  EXPECT_GT(positive, 8);
  EXPECT_LT(positive, 32);
}

/// The same pattern has one tree, whoever asks; other values give other factors, the same values
/// the same bits.
TEST(FrontalLU, KeepsTheAnalysisOfAPattern) {
  const SparseMatrix A = grid_matrix(12, 3, 1, 4), B = grid_matrix(12, 3, 2, 4);
  const SparseMatrix other = grid_matrix(11, 3, 1, 4);
  const auto tree = FrontalTree::of(A);
  EXPECT_EQ(FrontalTree::of(B), tree);
  EXPECT_NE(FrontalTree::of(other), tree);
  EXPECT_TRUE(tree->is_of(B));
  EXPECT_FALSE(tree->is_of(other));
  const Vector b = random_vector(static_cast<int>(A.cols()), 3);
  FrontalLU one, two;
  Vector x, y, z;
  ASSERT_TRUE(one.factor(A));
  one.solve(b, x);
  ASSERT_TRUE(two.factor(other));  // another pattern in between
  ASSERT_TRUE(two.factor(B));
  two.solve(b, y);
  ASSERT_TRUE(two.factor(A));
  two.solve(b, z);
  EXPECT_NE(x, y);
  EXPECT_EQ(x, z);
  FrontalTree::forget();
  FrontalLU three;
  ASSERT_TRUE(three.factor(A));
  three.solve(b, z);
  EXPECT_NE(FrontalTree::of(A), tree);
  EXPECT_EQ(x, z) << "an analysis made again is the same";
}

/// Trees of large patterns are not heaped up: of two that take more than what is kept, the last
/// stays.
TEST(FrontalLU, LetsTreesGoThatTakeMuchMemory) {
  const SparseMatrix A = grid_matrix(99, 3, 1, 4), B = grid_matrix(100, 3, 1, 4);
  const std::weak_ptr<const FrontalTree> first = FrontalTree::of(A);
  ASSERT_FALSE(first.expired());
  EXPECT_GT(2 * first.lock()->num_bytes(), std::size_t{1} << 21);
  const std::weak_ptr<const FrontalTree> second = FrontalTree::of(B);
  EXPECT_TRUE(first.expired());
  EXPECT_FALSE(second.expired());
  const SparseMatrix small = grid_matrix(12, 3, 1, 4);
  const std::weak_ptr<const FrontalTree> third = FrontalTree::of(small);
  EXPECT_FALSE(second.expired()) << "both fit in";
  EXPECT_FALSE(third.expired());
  FrontalTree::forget();
}

/// A diagonal block of zeros on the diagonal needs exchanges: [0 1; 1 0] has none without.
TEST(FrontalLU, ExchangesRowsWithinAFront) {
  SparseMatrix A = grid_matrix(1, 2, 1, 0);
  A.coeffRef(0, 0) = A.coeffRef(1, 1) = 0;
  A.coeffRef(0, 1) = 2;
  A.coeffRef(1, 0) = 4;
  FrontalLU lu;
  ASSERT_TRUE(lu.factor(A));
  EXPECT_EQ(lu.determinant_sign(), -1);
  Vector x;
  lu.solve(Vec2(6, 8), x);  // 2 y = 6, 4 x = 8
  EXPECT_DOUBLE_EQ(x[0], 2);
  EXPECT_DOUBLE_EQ(x[1], 3);
}

/// Pivots that a front cannot avoid show in the multiplier: all of the diagonal is 1e-12 beside
/// couplings of one.
TEST(FrontalLU, TellsOfSmallPivots) {
  SparseMatrix A = grid_matrix(20, 1, 5, 8);
  FrontalLU lu;
  ASSERT_TRUE(lu.factor(A));
  EXPECT_LT(lu.largest_multiplier(), 2);
  for (int j = 0; j < A.cols(); ++j) A.coeffRef(j, j) = 1e-12;
  ASSERT_TRUE(lu.factor(A));
  EXPECT_GT(lu.largest_multiplier(), 10);
}

TEST(FrontalLU, RefusesSingularAndNonFiniteMatricesAndRecovers) {
  const SparseMatrix good = grid_matrix(6, 2, 1, 5);
  FrontalLU lu;
  Vector x;
  EXPECT_THROW(lu.solve(random_vector(72, 1), x), std::logic_error);
  EXPECT_THROW((void)lu.determinant_sign(), std::logic_error);
  const SparseMatrix infinite = kInfinity * good, undefined = kNaN * good;
  EXPECT_FALSE(lu.factor(SparseMatrix(0.0 * good)));
  EXPECT_FALSE(lu.factor(infinite));
  EXPECT_FALSE(lu.factor(undefined));
  EXPECT_THROW(lu.solve(random_vector(72, 1), x), std::logic_error);
  ASSERT_TRUE(lu.factor(good));
  const Vector b = random_vector(72, 1);
  lu.solve(b, x);
  EXPECT_LT((good * x - b).norm(), 1e-13 * b.norm());
}

TEST(FrontalLU, StopsWithinAFrontAndRecovers) {
  constexpr int kSize = 1300;
  const SparseMatrix A = full_matrix(kSize);
  int questions = 0, answered = 2;
  FrontalLU stopped, free;
  stopped.stop_by(FactorStop([&] { return ++questions > answered; }));
  EXPECT_THROW((void)stopped.factor(A), FactorStopped);
  EXPECT_EQ(questions, 3);  // and not again with other scales
  const Vector b = random_vector(kSize, 1);
  Vector x, y;
  EXPECT_THROW(stopped.solve(b, x), std::logic_error);
  answered = 1000;
  ASSERT_TRUE(stopped.factor(A) && free.factor(A));
  EXPECT_GT(questions, 5);
  stopped.solve(b, x);
  free.solve(b, y);
  EXPECT_EQ(x, y);
  EXPECT_LT((A * x - b).norm(), 1e-12 * b.norm());
}

/// Scaled by powers of two on both sides, down to 1e-150: the same solution to the bit, scaled.
TEST(FrontalLU, DoesNotDependOnUnits) {
  const SparseMatrix A = grid_matrix(9, 2, 4, 4);
  const int n = static_cast<int>(A.cols());
  Vector scale(n);
  for (int j = 0; j < n; ++j) scale[j] = std::exp2(-250 + 3 * (j % 7));
  const SparseMatrix B = scale.asDiagonal() * A * scale.asDiagonal();
  const Vector b = random_vector(n, 2);
  FrontalLU one, two;
  ASSERT_TRUE(one.factor(A));
  ASSERT_TRUE(two.factor(B));
  Vector x, y;
  one.solve(b, x);
  two.solve(b.cwiseProduct(scale), y);
  EXPECT_LT((y.cwiseProduct(scale) - x).norm(), 1e-13 * x.norm());
}

/// A matrix as its columns and rows give it, line by line.
class GridByLines final : public FrontalLU::MatrixByLines {
 public:
  explicit GridByLines(SparseMatrix matrix) : matrix_(std::move(matrix)), rows_(matrix_) {}
  double diagonal(int j) const override { return matrix_.coeff(j, j); }
  void add_column(int j, FrontalLU::Line& to) const override {
    for (SparseMatrix::InnerIterator it(matrix_, j); it; ++it) {
      to.add(static_cast<int>(it.row()), it.value());
    }
  }
  void add_row(int i, FrontalLU::Line& to) const override {
    for (SparseRows::InnerIterator it(rows_, i); it; ++it) {
      if (to.takes(static_cast<int>(it.col()))) to.add(static_cast<int>(it.col()), it.value());
    }
  }

 private:
  SparseMatrix matrix_;
  SparseRows rows_;
};

/// The same bits as from a stored matrix, by either kind of scales.
TEST(FrontalLU, TakesAMatrixLineByLine) {
  SparseMatrix A = grid_matrix(20, 2, 7, 4);
  const int n = static_cast<int>(A.cols());
  const Vector b = random_vector(n, 3);
  // The last time with a diagonal that is no measure of the entries beside it.
  for (const double diagonal : {1.0, 1e-8}) {
    A.coeffRef(5, 5) *= diagonal;
    A.coeffRef(n - 1, n - 1) *= diagonal;
    FrontalLU stored, lines;
    EXPECT_THROW((void)lines.factor(GridByLines(A)), std::logic_error);
    ASSERT_TRUE(stored.factor(A));
    lines.analyse(A);
    ASSERT_TRUE(lines.factor(GridByLines(A)));
    Vector x, y;
    stored.solve(b, x);
    lines.solve(b, y);
    EXPECT_EQ(x, y);
    EXPECT_LT((A * x - b).norm(), 1e-9 * b.norm());
  }
  A.coeffRef(7, 7) = kInfinity;
  FrontalLU infinite;
  infinite.analyse(A);
  EXPECT_FALSE(infinite.factor(GridByLines(A)));
}

}  // namespace
}  // namespace bipot
