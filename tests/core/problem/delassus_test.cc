#include "core/problem/delassus.h"

#include <Eigen/Dense>
#include <thread>

#include "core/base/portable_random.h"
#include "tests/support/manufactured.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

using Eigen::MatrixXd;

/// Couples each body's degrees of freedom with the next body's, diagonally dominant.
SparseMatrix general_mass(int n, unsigned seed) {
  PortableRandom draw(seed);
  MatrixXd A = MatrixXd::Zero(n, n);
  for (int k = 0; k < n; ++k) {
    A(k, k) = 2 + draw.uniform();
    if (k + 1 < n) A(k, k + 1) = A(k + 1, k) = 0.9 * draw.symmetric();
  }
  return A.sparseView();
}

MatrixXd dense_delassus(const ContactProblem& p) {
  const MatrixXd A(p.A), H(p.H);
  return H.transpose() * A.llt().solve(H);
}

class Delassus : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(, Delassus, testing::Values(1, 2, 3),
                         [](const auto& i) { return "d" + std::to_string(i.param); });

TEST_P(Delassus, IsTheDenseProduct) {
  ContactProblem p = manufactured_problem(GetParam(), 9, 14, 1).problem;
  const MatrixXd dense = dense_delassus(p);
  EXPECT_LT((MatrixXd(assemble_delassus(p.A, p.H, p.dim)) - dense).norm(), 1e-14 * dense.norm());
  p.A = general_mass(p.num_dofs(), 2);
  const MatrixXd general = dense_delassus(p);
  EXPECT_FALSE(is_diagonal(p.A));
  EXPECT_LT((MatrixXd(assemble_delassus(p.A, p.H, p.dim)) - general).norm(),
            1e-13 * general.norm());
}

TEST_P(Delassus, IsSymmetricBitForBitInWholeSortedBlocks) {
  const int d = GetParam();
  ContactProblem p = manufactured_problem(d, 9, 14, 1).problem;
  for (const SparseMatrix& A : {p.A, general_mass(p.num_dofs(), 2)}) {
    const SparseRows W = assemble_delassus(A, p.H, d);
    EXPECT_TRUE(W.isCompressed());
    const MatrixXd dense(W);
    EXPECT_EQ(dense, MatrixXd(dense.transpose()));
  }
  const SparseRows W = assemble_delassus(p.A, p.H, d);
  for (int row = 0; row < W.rows(); ++row) {
    int entries = 0, previous = -1;
    for (SparseRows::InnerIterator it(W, row); it; ++it) {
      EXPECT_GT(it.col(), previous);
      EXPECT_EQ(it.col() % d, entries % d);
      previous = static_cast<int>(it.col());
      ++entries;
    }
    EXPECT_EQ(entries % d, 0);
  }
}

TEST_P(Delassus, TwoPassesAreTheExplicitProduct) {
  const Manufactured m = manufactured_problem(GetParam(), 9, 14, 1);
  const DelassusOperator two_pass(m.problem, DelassusOperator::Form::kTwoPass);
  const DelassusOperator explicit_form(m.problem, DelassusOperator::Form::kExplicit);
  Vector a, b;
  two_pass.apply(m.s, a);
  explicit_form.apply(m.s, b);
  EXPECT_LT((a - b).norm(), 1e-14 * a.norm());
  EXPECT_LT((a - dense_delassus(m.problem) * m.s).norm(), 1e-14 * a.norm());
  two_pass.velocity(m.s, a);
  EXPECT_LT((a - m.u).norm(), 1e-14 * m.problem.u_free.norm());
}

TEST_P(Delassus, DiagonalsAreThoseOfTheDenseProduct) {
  const int d = GetParam();
  ContactProblem p = manufactured_problem(d, 9, 14, 1).problem;
  const MatrixXd dense = dense_delassus(p);
  for (const auto form : {DelassusOperator::Form::kTwoPass, DelassusOperator::Form::kExplicit}) {
    const DelassusOperator W(p, form);
    EXPECT_LT((W.diagonal() - dense.diagonal()).norm(), 1e-14 * dense.norm());
    for (int c = 0; c < p.num_contacts(); ++c) {
      EXPECT_LT((W.diagonal_block(c) - dense.block(c * d, c * d, d, d)).norm(),
                1e-14 * dense.norm());
    }
  }
}

TEST_P(Delassus, GeneralMassMatrixIsAssembledWhereNoOperatorIsGiven) {
  Manufactured m = manufactured_problem(GetParam(), 9, 14, 1);
  m.problem.A = general_mass(m.problem.num_dofs(), 2);
  m.problem.W = SparseRows();
  const DelassusOperator W(m.problem);
  Vector u;
  W.apply(m.s, u);
  EXPECT_LT((u - dense_delassus(m.problem) * m.s).norm(), 1e-13 * u.norm());
  EXPECT_THROW(DelassusOperator(m.problem, DelassusOperator::Form::kTwoPass),
               std::invalid_argument);
}

TEST_P(Delassus, BodyVelocitiesFollowFromTheImpulses) {
  Manufactured m = manufactured_problem(GetParam(), 9, 14, 1);
  ContactProblem& p = m.problem;
  PortableRandom draw(4);
  for (double& x : p.v_free) x = draw.symmetric();
  for (const SparseMatrix& A : {p.A, general_mass(p.num_dofs(), 2)}) {
    p.A = SparseMatrix(A);
    const Vector v = body_velocities(p, m.s);
    const Vector residual = MatrixXd(p.A) * (v - p.v_free) - MatrixXd(p.H) * m.s;
    EXPECT_LT(residual.norm(), 1e-13 * m.s.norm());
  }
}

TEST(DelassusOperator, ProblemsWithoutBodiesHaveNoBodyVelocities) {
  Manufactured m = manufactured_problem(2, 4, 5, 1);
  m.problem.H = SparseMatrix();
  EXPECT_THROW(body_velocities(m.problem, m.s), std::invalid_argument);
}

TEST(DelassusOperator, RefusesAnIndefiniteMassMatrix) {
  Manufactured m = manufactured_problem(2, 4, 5, 1);
  m.problem.A.coeffRef(0, 1) = m.problem.A.coeffRef(1, 0) = 100;
  EXPECT_THROW(assemble_delassus(m.problem.A, m.problem.H, 2), std::runtime_error);
}

TEST(DelassusOperator, StoredZerosOffTheDiagonalAreStillDiagonal) {
  SparseMatrix A(2, 2);
  A.insert(0, 0) = 1;
  A.insert(1, 1) = 2;
  A.insert(0, 1) = 0;
  EXPECT_TRUE(is_diagonal(A));
  A.coeffRef(0, 1) = 1e-300;
  EXPECT_FALSE(is_diagonal(A));
}

TEST_P(Delassus, ACopyStandsOnItsOwn) {
  // A general A and no W: the operator assembles its own.
  ContactProblem p = manufactured_problem(GetParam(), 9, 14, 1).problem;
  p.A = general_mass(p.num_dofs(), 2);
  p.W = SparseRows();
  ContactProblem other = p;
  other.A = general_mass(p.num_dofs(), 3);
  const Vector s = Vector::LinSpaced(p.num_rows(), -1, 2);
  std::optional<DelassusOperator> original(p);
  const DelassusOperator copy(*original);
  const DelassusOperator moved(DelassusOperator{copy});
  Vector expected, u;
  original->apply(s, expected);
  original.emplace(other);  // another operator where the first one lay
  copy.apply(s, u);
  EXPECT_EQ(u, expected);
  moved.apply(s, u);
  EXPECT_EQ(u, expected);
  original->apply(s, u);
  EXPECT_NE(u, expected);
}

TEST_P(Delassus, EachThreadMayUseItsOwnCopy) {
  ContactProblem p = manufactured_problem(GetParam(), 9, 14, 1).problem;
  const DelassusOperator first(p, DelassusOperator::Form::kTwoPass);
  const auto apply_often = [&](const DelassusOperator& W, double scale, bool& same) {
    const Vector s = scale * Vector::LinSpaced(p.num_rows(), -1, 2);
    Vector expected, u;
    W.apply(s, expected);
    same = true;
    for (int k = 0; k < 20000; ++k) {
      W.apply(s, u);
      same = same && u == expected;
    }
  };
  bool same[2] = {};
  std::thread beside([&, copy = first] { apply_often(copy, 3, same[1]); });
  apply_often(first, 1, same[0]);
  beside.join();
  EXPECT_TRUE(same[0]);
  EXPECT_TRUE(same[1]);
}

}  // namespace
}  // namespace bipot
