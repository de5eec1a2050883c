#include "core/problem/compliance.h"

#include "core/problem/delassus.h"
#include "tests/support/converged.h"
#include "tests/support/manufactured.h"

namespace bipot {
namespace {

SparseRows diagonal(const Vector& values) {
  return SparseRows(SparseMatrix(Eigen::MatrixXd(values.asDiagonal()).sparseView()));
}

/// A block of mass 2 that falls with 1 m/s and slides with u_t.
ContactProblem block_on_ground(double u_t, double mu) {
  ContactProblem p{.dim = 2};
  p.A = Eigen::MatrixXd(Eigen::Vector2d(2, 2).asDiagonal()).sparseView();
  p.H = Eigen::MatrixXd::Identity(2, 2).sparseView();
  p.v_free = p.u_free = Eigen::Vector2d(-1, u_t);
  p.mu = Vector::Constant(1, mu);
  return p;
}

// W = 1/2 in both rows, R = (1/2, 3/2). It sticks: s_n = 1/(1/2 + 1/2) = 1, s_t = -0.4/(1/2 + 3/2)
// = -0.2 within 0.5 s_n. The block itself still falls with -R_n s_n = -0.5 and slides with -R_t s_t
// = 0.3. At u_t = 3 it slides: s_t = -0.5, u_t = 3 - 2 * 0.5 = 2, and the block has 3 - 0.5/2.
TEST(Compliance, ABlockSinksAndSlidesAsDerived) {
  for (const char* solver : {"auto", "pgs", "ipm"}) {
    const ContactProblem sticks =
        with_compliance(block_on_ground(0.4, 0.5), diagonal(Eigen::Vector2d(0.5, 1.5)));
    EXPECT_EQ(validate(sticks), "");
    SolveResult r = converged(solve(solver, sticks, {.tol = 1e-11}));
    EXPECT_LT((r.s - Vector(Eigen::Vector2d(1, -0.2))).norm(), 1e-9) << solver;
    EXPECT_LT(r.u.norm(), 1e-9);
    EXPECT_LT((body_velocities(sticks, r.s).head(2) - Eigen::Vector2d(-0.5, 0.3)).norm(), 1e-9);
    const ContactProblem slides =
        with_compliance(block_on_ground(3, 0.5), diagonal(Eigen::Vector2d(0.5, 1.5)));
    r = converged(solve(solver, slides, {.tol = 1e-11}));
    EXPECT_LT((r.u - Vector(Eigen::Vector2d(0, 2))).norm(), 1e-9);
    EXPECT_LT((body_velocities(slides, r.s).head(2) - Eigen::Vector2d(-0.5, 2.75)).norm(), 1e-9);
  }
}

// With bodies, the operator is that of W alone with W + R: full blocks, one of rank 1, one of 0.
TEST(Compliance, OfBodiesIsThatOfW) {
  for (const int d : {1, 2, 3}) {
    ContactProblem p = manufactured_problem(d, 6, 8, 3).problem;
    p.W = SparseRows();
    SparseRows R(p.num_rows(), p.num_rows());
    for (int c = 0; c + 1 < p.num_contacts(); ++c) {
      Eigen::MatrixXd L = Eigen::MatrixXd::Constant(d, d, 0.1);
      if (c > 0) L.diagonal().setConstant(0.5 + c);
      const Eigen::MatrixXd block = L * L.transpose();
      for (int k = 0; k < d * d; ++k)
        R.coeffRef(c * d + k / d, c * d + k % d) = block(k / d, k % d);
    }
    const SparseRows W = assemble_delassus(p.A, p.H, d);
    const ContactProblem bodies = with_compliance(p, R);
    EXPECT_EQ(bodies.num_dofs(), p.num_dofs() + 1 + (p.num_contacts() - 2) * d);
    const SparseRows both = assemble_delassus(bodies.A, bodies.H, d);
    EXPECT_LT((Eigen::MatrixXd(both) - Eigen::MatrixXd(SparseRows(W + R))).norm(), 1e-13);
    ContactProblem local{.dim = d, .W = W, .u_free = p.u_free, .mu = p.mu};
    local = with_compliance(local, R);
    const SolveResult one = converged(solve("auto", bodies, {.tol = 1e-11}));
    const SolveResult other = converged(solve("auto", local, {.tol = 1e-11}));
    EXPECT_LT((one.u - other.u).norm(), 1e-7 * (1 + one.u.norm()));
  }
}

TEST(Compliance, WhatIsNoComplianceIsNamed) {
  const ContactProblem p = manufactured_problem(2, 3, 2, 3).problem;
  const auto refused = [&](int row, int column, double value, const std::string& words) {
    SparseRows R(4, 4);
    R.coeffRef(row, column) = value;
    EXPECT_TRUE(says(refusal_of([&] { with_compliance(p, R); }), words));
  };
  refused(0, 3, 1, "R(0, 3) = 1, expected 0 between two contacts");
  refused(2, 2, kNaN, "R(2, 2) = nan, expected a finite number");
  refused(2, 2, -1, "R of contact 1 is not symmetric and positive semidefinite");
  refused(0, 1, 1, "R of contact 0 is not symmetric");
  EXPECT_TRUE(says(refusal_of([&] { with_compliance(p, SparseRows(3, 4)); }),
                   "R is 3 x 4, expected 4 x 4"));
  const ContactProblem joined = manufactured_joints(2, 3, 2, 3).problem;
  EXPECT_TRUE(says(refusal_of([&] { with_compliance(joined, SparseRows(4, 4)); }),
                   "R does not go with equality rows"));
}

}  // namespace
}  // namespace bipot
