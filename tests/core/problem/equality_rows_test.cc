#include "core/problem/equality_rows.h"

#include "core/criterion/contact_error.h"
#include "core/problem/delassus.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

using Eigen::MatrixXd;

struct Dimension : testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(EqualityRows, Dimension, testing::Values(1, 2, 3),
                         testing::PrintToStringParamName());

Vector velocity_at(const ContactProblem& p, const Vector& s) {
  Vector u;
  DelassusOperator(p).velocity(s, u);
  return u;
}

TEST_P(Dimension, TheManufacturedAnswerIsOne) {
  const ManufacturedJoints m = manufactured_joints(GetParam(), 9, 12, 5);
  const ContactProblem& p = m.problem;
  EXPECT_EQ(validate(p), "");
  EXPECT_EQ(p.num_dofs(), m.v.size() - static_cast<int>(m.multipliers.size()));
  EXPECT_TRUE(is_diagonal(p.A));
  EXPECT_LE((velocity_at(p, m.s) - m.u).norm(), 1e-12 * m.u.norm());
  EXPECT_LE(contact_error(p, m.s).guarded(), 1e-12);
  EXPECT_LE((body_velocities(p, m.s) - m.v).norm(), 1e-12 * m.v.norm());
  EXPECT_LE((multipliers(p, m.s) - m.multipliers).norm(), 1e-10 * m.multipliers.norm());
  EXPECT_LE(equality_residual(p, m.s), 1e-13);
}

TEST_P(Dimension, BodiesThatNoRowTouchesKeepTheirBits) {
  const ManufacturedJoints m = manufactured_joints(GetParam(), 9, 12, 5);
  const ContactProblem& p = m.problem;
  const ContactProblem& given = without_equality_rows(p);
  const int joined = 3 * static_cast<int>(m.multipliers.size());
  int kept = 0;
  for (int i = 0; i < p.num_rows(); ++i) {
    bool touched = false;
    for (SparseMatrix::InnerIterator it(given.H, i); it; ++it) touched |= it.row() < joined;
    if (touched) continue;
    ++kept;
    EXPECT_EQ(p.u_free[i], given.u_free[i]);
    const Vector column = given.H.col(i);
    EXPECT_EQ(Vector(p.H.col(i)).head(column.size() - joined), column.tail(column.size() - joined));
  }
  EXPECT_GT(kept, GetParam());
}

TEST_P(Dimension, RowsThatDependOnOthersChangeNothing) {
  const ManufacturedJoints m = manufactured_joints(GetParam(), 9, 12, 5);
  const EqualityRows& rows = *m.problem.equality;
  const int n = static_cast<int>(rows.G.rows());
  MatrixXd G(n + 2, rows.G.cols());
  G << rows.G.toDense(), -3 * rows.G.toDense().row(0), rows.G.toDense().colwise().sum();
  Vector b(n + 2);
  b << rows.b, -3 * rows.b[0], rows.b.sum();
  const ContactProblem p = with_equality_rows(rows.given, G.sparseView(), b);
  EXPECT_EQ(p.num_dofs(), m.problem.num_dofs());
  EXPECT_LE((velocity_at(p, m.s) - m.u).norm(), 1e-12 * m.u.norm());
  EXPECT_LE((body_velocities(p, m.s) - m.v).norm(), 1e-12 * m.v.norm());
  // The impulses on the bodies are the same, shared out in another way.
  const Vector shared = multipliers(p, m.s);
  const Vector impulse = rows.G.transpose() * m.multipliers;
  EXPECT_LE((G.transpose() * shared - impulse).norm(), 1e-10 * impulse.norm());
  EXPECT_GT(shared[n + 1], 1e-3 * shared.norm());

  b[n] += 0.5;
  EXPECT_TRUE(says(
      refusal_of<std::invalid_argument>([&] { with_equality_rows(rows.given, G.sparseView(), b); }),
      "of G contradicts other rows: b["));
}

TEST(EqualityRows, AGeneralMassMatrixIsTaken) {
  // A = [2 1 0; 1 2 0; 0 0 4], G = (1 1 0), b = 3, contacts along x, y + z. With v = (3/2 + q, 3/2 -
  // q, z): mass of q is 2 - 2 + 2 = 2, q of the free motion is (x - y)/2. W_xx = 1/2, W_xy = -1/2,
  // W_yy = 1/2 + 1/4.
  ContactProblem p{.dim = 1};
  MatrixXd A(3, 3), H(3, 2), G(1, 3);
  A << 2, 1, 0, 1, 2, 0, 0, 0, 4;
  H << 1, 0, 0, 1, 0, 1;
  G << 1, 1, 0;
  p.A = A.sparseView();
  p.H = H.sparseView();
  p.v_free = Eigen::Vector3d(7, 1, -5);
  p.u_free = H.transpose() * p.v_free;
  p.mu = Vector::Zero(2);
  p = with_equality_rows(p, G.sparseView(), Vector::Constant(1, 3.0));
  EXPECT_LE((velocity_at(p, Vector::Zero(2)) - Eigen::Vector2d(4.5, -6.5)).norm(), 1e-14);
  MatrixXd W(2, 2);
  W << 0.5, -0.5, -0.5, 0.75;
  EXPECT_LE((MatrixXd(assemble_delassus(p.A, p.H, 1)) - W).norm(), 1e-14);
  EXPECT_LE((body_velocities(p, Eigen::Vector2d(2, 0)) - Eigen::Vector3d(5.5, -2.5, -5)).norm(),
            1e-14);
  // A (v - v_free) = H s + G^T lambda.
  const Vector change = body_velocities(p, Eigen::Vector2d(2, 0)) - Eigen::Vector3d(7, 1, -5);
  const Vector impulse = G.transpose() * multipliers(p, Eigen::Vector2d(2, 0));
  EXPECT_LE((A * change - H * Eigen::Vector2d(2, 0) - impulse).norm(), 1e-14);
}

TEST(EqualityRows, LenientEliminationTakesTheNearestVelocitiesAndRidsOfBlockedContacts) {
  ContactProblem p =
      unit_masses(1, MatrixXd::Identity(2, 2), Eigen::Vector2d(-1, -2), Vector::Zero(2));
  MatrixXd G(2, 2);
  G << 1, 0, 1, 0;  // v_x = 3 and 4: 3.5
  p = with_equality_rows(p, G.sparseView(), Eigen::Vector2d(3, 4), true);
  EXPECT_EQ(validate(p), "");
  EXPECT_LE((p.u_free - Eigen::Vector2d(3.5, -2)).norm(), 1e-14);
  EXPECT_LE((body_velocities(p, Eigen::Vector2d(7, 2)) - Eigen::Vector2d(3.5, 0)).norm(), 1e-14);
}

TEST(EqualityRows, DefectsAreRefusedWithTheRowOrTheContact) {
  ContactProblem p =
      unit_masses(1, MatrixXd::Identity(2, 2), Eigen::Vector2d(-1, -2), Vector::Zero(2));
  const auto refusal = [&](const MatrixXd& G, const Vector& b) {
    return refusal_of<std::invalid_argument>(
        [&] { with_equality_rows(p, SparseRows(G.sparseView()), b); });
  };
  const MatrixXd one = Eigen::RowVector2d(1, 0);
  const Vector zero = Vector::Zero(1);
  EXPECT_TRUE(
      says(refusal(MatrixXd::Ones(1, 3), zero), "G is 1 x 3 and b has size 1, expected p x 2"));
  EXPECT_TRUE(says(refusal(one, Vector::Zero(2)), "G is 1 x 2 and b has size 2"));
  EXPECT_TRUE(says(refusal(one * kNaN, zero), "row 0 of G is not finite"));
  EXPECT_TRUE(says(refusal(one, Vector::Constant(1, kInfinity)), "b[0] = inf is not finite"));
  EXPECT_TRUE(says(refusal(0 * one, Vector::Ones(1)), "row 0 of G is zero, but b[0] = 1"));
  EXPECT_TRUE(
      says(refusal(one, zero), "contact 0: the equality rows leave no motion along its normal"));
  MatrixXd two(2, 2);
  two << 1, 1, 2, 2;
  // In rows of unit norm: b/√2 and b/√8, of which the mean is right for both.
  EXPECT_TRUE(says(refusal(two, Eigen::Vector2d(0, 4)), "of G contradicts other rows: b["));
  EXPECT_FALSE(says(refusal(two, Eigen::Vector2d(1, 2)), "contradicts"));
  ContactProblem bodiless{.dim = 1, .u_free = zero, .mu = zero};
  EXPECT_TRUE(says(refusal_of<std::invalid_argument>(
                       [&] { with_equality_rows(bodiless, SparseRows(one.sparseView()), zero); }),
                   "equality rows need bodies"));
  p.A.resize(5001, 5001);
  p.A.setIdentity();
  p.H.resize(5001, 0);
  p.v_free = Vector::Zero(5001);
  p.u_free = p.mu = Vector();
  EXPECT_TRUE(says(refusal(MatrixXd::Ones(1, 5001), zero), "couple 5001 degrees of freedom"));
}

}  // namespace
}  // namespace bipot
