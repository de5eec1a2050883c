#include "core/problem/delassus.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// A frictionless problem of this W.
ContactProblem problem_of(const Eigen::MatrixXd& w) {
  return delassus_problem(1, w, -Vector::Ones(w.rows()), Vector::Zero(w.rows()));
}

// Eigenvalues 3 and -1.
TEST(DelassusCheck, AnIndefiniteMatrixIsNamedWithItsEigenvalue) {
  const std::string defect = delassus_defect(problem_of(Eigen::Matrix2d{{1, 2}, {2, 1}}));
  EXPECT_TRUE(says(defect, "not positive semidefinite"));
  EXPECT_TRUE(says(defect, "at most -1,"));
}

// Scaled to a diagonal of 1 this is the same matrix: units do not matter.
TEST(DelassusCheck, UnitsDoNotMatter) {
  EXPECT_NE(delassus_defect(problem_of(Eigen::Matrix2d{{1e-6, 2}, {2, 1e6}})), "");
  EXPECT_EQ(delassus_defect(problem_of(Eigen::Matrix2d{{1e-6, 0.9}, {0.9, 1e6}})), "");
}

TEST(DelassusCheck, AnAsymmetricMatrixIsNamedWithItsEntries) {
  EXPECT_EQ(delassus_defect(problem_of(Eigen::Matrix2d{{2, 0.5}, {1, 2}})),
            "W is not symmetric: W(0, 1) = 0.5, W(1, 0) = 1");
}

// With D = W - Wᵀ and t = 0.5: |D| / |W| = √2 e / √(2 + t² + (t + e)²) is 1.8e-2 and 4.5e-3 in the
// Frobenius norm for e = 0.02 and 0.005; 1e-2 is the limit.
TEST(DelassusCheck, AsymmetryIsMeasuredInTheWhole) {
  EXPECT_NE(delassus_defect(problem_of(Eigen::Matrix2d{{1, 0.5}, {0.52, 1}})), "");
  EXPECT_EQ(delassus_defect(problem_of(Eigen::Matrix2d{{1, 0.5}, {0.505, 1}})), "");
}

// Beside 400 diagonal entries a single one is small in the norm, 0.15/20; as an entry it is not.
TEST(DelassusCheck, AsymmetryOfOneEntryIsSeenInALargeMatrix) {
  for (const double e : {0.05, 0.15}) {
    Eigen::MatrixXd w = Eigen::MatrixXd::Identity(400, 400);
    w(17, 300) = e;
    EXPECT_EQ(delassus_defect(problem_of(w)).empty(), e < 0.1) << e;
  }
}

// A singular W = g gᵀ, each entry rounded to six digits in its own way, and slightly indefinite.
TEST(DelassusCheck, DataOfSixDigitsPass) {
  Eigen::MatrixXd w(4, 4);
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) w(i, j) = (1 + i / 3.0) * (1 + j / 3.0);
  }
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) w(i, j) *= 1 + 5e-6 * ((3 * i + 2 * j) % 3 - 1);
  }
  EXPECT_EQ(delassus_defect(problem_of(w)), "");
}

// Beyond 300 rows: a chain 1, c, c has the eigenvalues 1 + 2 c cos: with c = 0.49 all are positive,
// with c = 0.6 the smallest is near -0.2.
TEST(DelassusCheck, ALargeMatrixIsLookedAtByProducts) {
  for (const double c : {0.49, 0.6}) {
    Eigen::MatrixXd w = Eigen::MatrixXd::Identity(400, 400);
    for (int i = 1; i < 400; ++i) w(i, i - 1) = w(i - 1, i) = c;
    EXPECT_EQ(delassus_defect(problem_of(w)).empty(), c < 0.5);
  }
}

TEST(DelassusCheck, WIsComparedWithAAndH) {
  ContactProblem p{.dim = 1,
                   .A = Eigen::MatrixXd::Constant(1, 1, 2).sparseView(),
                   .H = Eigen::MatrixXd::Ones(1, 2).sparseView(),
                   .v_free = -Vector::Ones(1),
                   .u_free = -Vector::Ones(2),
                   .mu = Vector::Zero(2)};
  EXPECT_EQ(delassus_defect(p), "");  // nothing to test
  p.W = assemble_delassus(p.A, p.H, 1);
  EXPECT_EQ(delassus_defect(p), "");
  p.W.coeffRef(0, 0) = 0.7;
  EXPECT_EQ(delassus_defect(p), "W is not that of A and H: W(0, 0) = 0.7, HᵀA⁻¹H has 0.5");
}

}  // namespace
}  // namespace bipot
