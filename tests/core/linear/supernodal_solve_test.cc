#include "core/linear/supernodal_solve.h"

#include <Eigen/Dense>
#include <deque>

#include "tests/support/random_vector.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// A lower triangular matrix of supernodes of these widths, each with about half of the rows below.
struct GivenSupernodes {
  std::deque<std::vector<int>> rows;
  std::deque<std::vector<float>> values;
  std::vector<SupernodalSolve::Supernode> nodes;
  Eigen::MatrixXd L;

  GivenSupernodes(const std::vector<int>& widths, double coupling, unsigned seed) {
    PortableRandom draw(seed);
    int size = 0, first = 0;
    for (int width : widths) size += width;
    L = Eigen::MatrixXd::Zero(size, size);
    for (int width : widths) {
      std::vector<int>& row = rows.emplace_back();
      for (int i = first; i < size; ++i) {
        if (i < first + width || draw.below(2) == 0) row.push_back(i);
      }
      std::vector<float>& value = values.emplace_back();
      for (int j = 0; j < width; ++j) {
        for (int i = 0; i < static_cast<int>(row.size()); ++i) {
          // What stands above the diagonal is not to be read.
          const auto x =
              static_cast<float>(i == j ? 2 + draw.symmetric() : coupling * draw.symmetric());
          value.push_back(i < j ? 1e30F : x);
          if (i >= j) L(row[to_size(i)], first + j) = x;
        }
      }
      nodes.push_back(
          {first, width, static_cast<int>(row.size()), row.data() + width, value.data()});
      first += width;
    }
  }
};

/// What is left of the error after a number of corrections x += L⁻ᵀ L⁻¹ (b - L Lᵀ x).
void expect_inverse(double coupling, int corrections, double tolerance) {
  SupernodalSolve solve;
  // Widths below, at and above slices of eight and strips of 32, alone and one after the
  // other; the object is used again for a matrix of another size.
  for (const std::vector<int>& widths : {std::vector<int>{1},
                                         {4},
                                         {9},
                                         {1, 5, 4, 7, 6},
                                         {3, 1, 1, 2, 8, 13, 5},
                                         {19, 40, 33},
                                         {2, 2}}) {
    const GivenSupernodes made(widths, coupling, 7);
    std::size_t entries = 0;
    for (const SupernodalSolve::Supernode& node : made.nodes) {
      entries += SupernodalSolve::num_entries(node.columns, node.rows);
    }
    solve.begin(static_cast<int>(made.L.rows()), entries);
    for (const SupernodalSolve::Supernode& node : made.nodes) solve.add(node);
    const Vector x = random_vector(made.L.rows(), 3);
    const Vector b = made.L * (made.L.transpose() * x);
    Vector solution = Vector::Zero(x.size());
    for (int k = 0; k < corrections; ++k) {
      const Vector residual = b - made.L * (made.L.transpose() * solution);
      std::vector<float> correction;
      for (const double r : residual) correction.push_back(static_cast<float>(r));
      solve.solve(correction.data());
      for (int i = 0; i < x.size(); ++i) solution[i] += correction[to_size(i)];
    }
    EXPECT_LT((solution - x).norm(), tolerance * x.norm()) << widths.size() << " supernodes";
  }
}

/// Triangles of 40 random columns have a condition of 1e4 and more, with couplings of a tenth below
/// 30.
TEST(SupernodalSolve, IsTheInverseOfLTimesItsTranspose) {
  expect_inverse(0.1, 1, 1e-5);
  expect_inverse(0.1, 3, 1e-13);
  expect_inverse(1, 6, 1e-9);
}

/// A triangle of 8 is one slice of 8 columns. 37 columns and 80 rows: rows 0 to 31 have four slices
/// of 32 columns (the diagonal ends there), 32 to 63 four of 37, 64 to 79 two of 37; 128 + 148 + 74
/// slices.
TEST(SupernodalSolve, KeepsNothingRightOfTheDiagonalOfAStrip) {
  EXPECT_EQ(SupernodalSolve::num_entries(1, 1), 8U);
  EXPECT_EQ(SupernodalSolve::num_entries(8, 8), 64U);
  EXPECT_EQ(SupernodalSolve::num_entries(37, 80), 8U * 350);
}

}  // namespace
}  // namespace bipot
