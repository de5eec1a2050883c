// Rolling friction as data: the criterion, and every solver that takes it.

#include "core/criterion/extended_error.h"
#include "core/criterion/impulse_verdict.h"
#include "core/criterion/rounding_bound.h"
#include "core/problem_files/fclib_file.h"
#include "solvers/analysis/existence.h"
#include "tests/support/converged.h"
#include "tests/support/manufactured.h"
#include "tests/support/temporary_folder.h"

namespace bipot {
namespace {

/// One body of mass 2 and inertia 0.5 in the plane on a fixed partner, arm 0.5: free velocity
/// (-1 towards it, u_t, w).
ContactProblem one_contact(double u_t, double w, double mu, double mu_r) {
  ContactProblem p{.dim = 3};
  const Eigen::Vector3d mass(2, 2, 0.5);
  p.A = Eigen::MatrixXd(mass.asDiagonal()).sparseView();
  Eigen::Matrix3d H;
  H << 0, -1, 0,   // x: of n = (0, 1), t = (-1, 0), moment
      1, 0, 0,     // y
      0, -0.5, 1;  // spin
  p.H = Eigen::MatrixXd(H).sparseView();
  p.v_free = Eigen::Vector3d(-u_t - 0.5 * w, -1, w);
  p.u_free = p.H.transpose() * p.v_free;
  p.mu = Vector::Constant(1, mu);
  p.mu_r = Vector::Constant(1, mu_r);
  return p;
}

// s_n = m = 2 stops the fall. Without sliding s_t = f, and m = -mu_r s_n while it rolls with w > 0:
// with u_t = 0 before, 0 = (1/2 + 0.25/0.5) f - 0.5 m / 0.5 gives f = m = -0.2 for mu_r = 0.1, and
// w changes by (m - 0.5 f)/0.5 = -0.2.
TEST(Rolling, OneContactRollsSticksOrOpensAsDerived) {
  for (const std::string& name : solver_names()) {
    const SolverEntry& entry = require_solver(name);
    if (!entry.rolls) continue;
    const SolveResult rolls =
        converged(solve(name, one_contact(0, 1, 0.5, 0.1), {.tol = 1e-8}), name);
    EXPECT_LT((rolls.s - Vector(Eigen::Vector3d(2, -0.2, -0.2))).norm(), 1e-6) << name;
    EXPECT_LT((rolls.u - Vector(Eigen::Vector3d(0, 0, 0.8))).norm(), 1e-6) << name;
    // The bound of 2 is more than enough to stop w = 1: m = -1 with f = -1 stops both.
    const SolveResult holds = converged(solve(name, one_contact(0, 1, 2, 1), {.tol = 1e-8}), name);
    EXPECT_LT((holds.s - Vector(Eigen::Vector3d(2, -1, -1))).norm(), 1e-6) << name;
    EXPECT_LT(holds.u.norm(), 1e-6) << name;
    ContactProblem up = one_contact(0, 1, 0.5, 0.1);
    up.v_free[1] = 1;
    up.u_free[0] = 1;
    EXPECT_EQ(solve(name, up).status, SolveStatus::kNothingToDo) << name;
  }
}

// The associated law minimises ½ s·W s + u_free·s on the cone: with m = -n/10 and f = m this is
// 0.255 n² - 1.1 n. So n = 2.2/1.02, and the contact opens with mu_r |w|, w = 1 + m.
TEST(Rolling, TheAssociatedLawOpensWhereItRolls) {
  const SolveResult r =
      ended(SolveStatus::kStalled, solve("convex", one_contact(0, 1, 0.5, 0.1), {.tol = 1e-10}));
  EXPECT_TRUE(says(r.message, "1 of 1 contacts slide or roll, and open with up to 0.0784 m/s"));
  EXPECT_NEAR(r.s[0], 2.2 / 1.02, 1e-8);
  EXPECT_NEAR(r.u[0], 0.1 * r.u[2], 1e-8);
}

TEST(Rolling, EverySolverAgreesAndTheOthersRefuse) {
  int able = 0;
  for (const int rows : {3, 6}) {
    for (const unsigned seed : {1u, 2u, 3u}) {
      if (rows == 6 && seed == 3) continue;  // sweeps need more than the limit
      const Manufactured made = manufactured_rolling(rows, 12, 18, seed);
      ContactProblem scaled = made.problem;
      scaled.row_scale = Vector::Constant(scaled.num_rows(), 1.1);
      for (int c = 0; c < scaled.num_contacts(); ++c) scaled.row_scale[c * rows] = 1.3;
      ContactProblem local = made.problem;
      local.A = local.H = SparseMatrix();
      local.v_free = Vector();
      ContactProblem bodies = made.problem;
      bodies.W = SparseRows();
      for (const ContactProblem* p : {&bodies, &local, &scaled}) {
        EXPECT_EQ(validate(*p), "");
        for (const SolverEntry& entry : solver_table()) {
          const SolveResult r =
              solve(entry.name, *p, {.tol = 1e-9, .max_iterations = 100000, .time_limit = 20});
          if (entry.rolls && entry.max_dim < 3 && rows == 6) continue;
          if (!entry.rolls) {
            EXPECT_EQ(r.status, SolveStatus::kInvalidInput) << entry.name;
            EXPECT_TRUE(says(r.message, "rolling friction"));
            continue;
          }
          ++able;
          EXPECT_TRUE(is_success(r.status)) << entry.name << ", rows " << rows << ": " << r.message;
          EXPECT_LT((r.u - made.u).norm(), 1e-5 * made.u.norm())
              << entry.name << ", rows " << rows << ", seed " << seed;
        }
      }
    }
  }
  EXPECT_GE(able, 150);
}

TEST(Rolling, TheCriterionIsZeroOnTheLawAlone) {
  for (const int rows : {3, 6}) {
    const Manufactured made = manufactured_rolling(rows, 8, 12, 4);
    EXPECT_LT(contact_error(made.problem, made.s).guarded(), 1e-14);
    for (int row = 0; row < made.problem.num_rows(); ++row) {
      if (made.s[row] == 0) continue;
      Vector s = made.s;
      s[row] *= 0.9;
      const ContactError off = contact_error(made.problem, s);
      EXPECT_GT(off.guarded(), 1e-6) << "row " << row;
      // Bounds on rounding hold, and longer numbers agree.
      const RoundingBound bound = rounding_bound(made.problem, s, Precision::kDouble);
      const double wide = quadruple_guarded_error(made.problem, s);
      EXPECT_LE(std::abs(wide - off.guarded()), bound.guarded());
      EXPECT_LT(bound.guarded(), 1e-11 * (1 + off.guarded()));
    }
  }
}

// Lengths in another unit: spins and mu stay, impulses and velocities change by it, moments and
// inertia by its square, mu_r by it.
TEST(Rolling, TheCriterionDoesNotDependOnUnits) {
  const ContactProblem p = one_contact(0.3, 1, 0.5, 0.1);
  constexpr double kUnit = 1000;
  ContactProblem q = p;
  q.A.coeffRef(2, 2) *= kUnit * kUnit;
  q.H.coeffRef(2, 1) *= kUnit;
  q.v_free.head<2>() *= kUnit;
  q.u_free = q.H.transpose() * q.v_free;
  q.mu_r *= kUnit;
  for (const Eigen::Vector3d& s : {Eigen::Vector3d(2, -0.2, -0.2), Eigen::Vector3d(1.5, 1, 0.1)}) {
    const ContactError a = contact_error(p, s);
    const ContactError b =
        contact_error(q, Eigen::Vector3d(kUnit * s[0], kUnit * s[1], kUnit * kUnit * s[2]));
    EXPECT_NEAR(b.epsilon / a.epsilon, 1, 1e-12);
    EXPECT_NEAR(b.eta / a.eta, 1, 1e-12);
    EXPECT_NEAR(b.natural_map / a.natural_map, 1, 1e-12);
  }
}

TEST(Rolling, AVerdictNamesTheFault) {
  const ContactProblem p = one_contact(0, 1, 0.5, 0.1);
  const auto expect = [&](const Eigen::Vector3d& s, const std::string& words) {
    const ImpulseVerdict v = judge(p, Vector(s));
    ASSERT_FALSE(v.worst.empty());
    EXPECT_TRUE(says(sentence(v.worst[0]), words));
  };
  expect({2, -0.2, -0.5}, "its moment is 3.0e-01 N m s beyond rolling friction");
  expect({2, 0, 0}, "rolls at 1.0e+00 rad/s inside");
  expect({2, 0.2, 0.2}, "rad/s, which its moment does not oppose");
  EXPECT_LT(judge(p, Vector(Eigen::Vector3d(2, -0.2, -0.2))).guarded(), 1e-14);
}

// One contact can be opened. Between two walls that close on a body nothing helps.
TEST(Rolling, ExistenceIsCertified) {
  EXPECT_EQ(certify_existence(one_contact(0, 1, 0.5, 0.1)).verdict, Existence::kExists);
  ContactProblem p = one_contact(0, 0, 0.5, 0.1);
  Eigen::Matrix<double, 3, 6> H;
  H << 1, 0, 0, -1, 0, 0,      // x: normals (1, 0) and (-1, 0)
      0, 1, 0, 0, -1, 0,       // y
      0, -0.5, 1, 0, -0.5, 1;  // spin
  p.H = Eigen::MatrixXd(H).sparseView();
  p.v_free.setZero();
  p.u_free = Vector::Zero(6);
  p.u_free[0] = p.u_free[3] = -1;
  p.mu = Vector::Constant(2, 0.5);
  p.mu_r = Vector::Constant(2, 0.1);
  EXPECT_EQ(certify_existence(p).verdict, Existence::kNone);
  p.u_free[3] = 1;
  EXPECT_NE(certify_existence(p).verdict, Existence::kNone);
  const Manufactured made = manufactured_rolling(6, 3, 2, 8);
  EXPECT_EQ(certify_existence(made.problem).verdict, Existence::kExists);
}

TEST(Rolling, DefectsAreNamed) {
  ContactProblem p = one_contact(0, 1, 0.5, 0.1);
  p.mu_r[0] = -1;
  EXPECT_TRUE(says(validate(p), "mu_r[0] = -1 is negative"));
  p.mu_r = Vector::Ones(2);
  EXPECT_TRUE(says(validate(p), "mu_r has size 2, expected 1"));
  p.mu_r = Vector::Ones(1);
  p.mu_spin = Vector::Ones(1);
  EXPECT_TRUE(says(validate(p), "mu_spin has size 1, expected 0"));
  p.dim = 2;
  EXPECT_TRUE(says(validate(p), "expected 3 or 6 rows"));
}

TEST(Rolling, ItsFileKeepsTheCoefficients) {
  const TemporaryFolder folder;
  for (const int rows : {3, 6}) {
    Manufactured made = manufactured_rolling(rows, 5, 7, 6);
    for (const bool local : {false, true}) {
      if (local) made.problem.A = made.problem.H = SparseMatrix();
      const auto path = folder.path() / (std::to_string(rows) + (local ? "l" : "g") + ".hdf5");
      write_fclib(path, made.problem, {});
      write_fclib_solution(path, made.s, made.u);
      const ProblemFile read = read_problem(path);
      EXPECT_EQ(read.problem.dim, rows);
      EXPECT_EQ(read.problem.mu_r, made.problem.mu_r);
      EXPECT_EQ(read.problem.mu_spin, made.problem.mu_spin);
      EXPECT_LT(contact_error(read.problem, *read.r).guarded(), 1e-13);
    }
  }
}

}  // namespace
}  // namespace bipot
