#include "solvers/methods/lemke.h"

#include <gtest/gtest.h>

#include "solvers/solve.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

SolveResult lemke(const ContactProblem& p, double tol = 1e-11) {
  return solve("lemke", p, {.tol = tol});
}

TEST(Lemke, OneContactTakesOffSticksAndSlips) {
  const Vector gentle = Vector::Constant(1, 0.3), strong = Vector::Constant(1, 3.0);
  // w_n = 2, w_t = 3, mu = 0.4, b_n = -1: s_n = 1/2, friction bound 0.2.
  SolveResult r = lemke(one_contact_problem(2, 2, 3, 0.4, -1, gentle));
  ASSERT_EQ(r.status, SolveStatus::kConverged) << r.message;
  EXPECT_NEAR(r.s[0], 0.5, 1e-14);
  EXPECT_NEAR(r.s[1], -0.1, 1e-14);
  r = lemke(one_contact_problem(2, 2, 3, 0.4, -1, strong));
  ASSERT_EQ(r.status, SolveStatus::kConverged) << r.message;
  EXPECT_NEAR(r.s[0], 0.5, 1e-14);
  EXPECT_NEAR(r.s[1], -0.2, 1e-14);
  EXPECT_NEAR(r.u[1], 2.4, 1e-14);
  r = lemke(one_contact_problem(2, 2, 3, 0.4, -1, -strong));
  ASSERT_EQ(r.status, SolveStatus::kConverged) << r.message;
  EXPECT_NEAR(r.s[1], 0.2, 1e-14);
  r = lemke(one_contact_problem(2, 2, 3, 0, -1, strong));
  ASSERT_EQ(r.status, SolveStatus::kConverged) << r.message;
  EXPECT_NEAR(r.s[0], 0.5, 1e-14);
  EXPECT_EQ(r.s[1], 0);
  r = lemke(one_contact_problem(1, 2, 3, 0, -1, Vector()));
  ASSERT_EQ(r.status, SolveStatus::kConverged) << r.message;
  EXPECT_NEAR(r.s[0], 0.5, 1e-14);
  EXPECT_EQ(lemke(one_contact_problem(2, 2, 3, 0.4, 1, strong)).status, SolveStatus::kNothingToDo);
}

TEST(Lemke, SolvesRandomNetworksExactlyAndAgreesWithGaussSeidel) {
  int compared = 0;
  for (int dim = 1; dim <= 2; ++dim) {
    for (unsigned seed = 1; seed <= 12; ++seed) {
      const Manufactured m = manufactured_problem(dim, 8, 10, seed);
      const SolveResult exact = lemke(m.problem);
      ASSERT_EQ(exact.status, SolveStatus::kConverged) << dim << seed << exact.message;
      EXPECT_LE(contact_error(m.problem, exact.s).guarded(), 1e-11);
      const SolveResult swept = solve("pgs", m.problem, {.tol = 1e-10});
      if (!is_success(swept.status)) continue;
      ++compared;
      EXPECT_LT((swept.u - exact.u).norm(), 1e-6 * m.problem.u_free.norm())
          << "d = " << dim << ", seed " << seed;
    }
  }
  EXPECT_GE(compared, 20);
}

TEST(Lemke, SolvesHyperstaticAndSymmetricScenes) {
  // W is singular and every vertex of the pyramid's path is degenerate; Siconos' Lemke goes wrong
  // from 55 contacts (square lattice of 5 rows).
  const ContactProblem problems[] = {
      lattice_step(Lattice::kSquare, 5, 0.3, 0), lattice_step(Lattice::kTriangular, 5, 0.3, 10),
      lattice_step(Lattice::kTriangular, 6, 0, 0), lattice_step(Lattice::kPyramid, 5, 0.5, 0),
      lattice_step(Lattice::kPyramid, 7, 0.3, 0)};
  for (const ContactProblem& p : problems) {
    const SolveResult r = lemke(p);
    EXPECT_EQ(r.status, SolveStatus::kConverged) << p.num_contacts() << r.message;
  }
}

TEST(Lemke, TakesAnUnsymmetricOperatorAsItIs) {
  const Manufactured m = manufactured_problem(2, 8, 8, 5);
  ContactProblem p = local_form(m.problem);
  for (int k = 0; k < p.W.nonZeros(); ++k) p.W.valuePtr()[k] *= 1 + 1e-3 * (k % 7);
  p.u_free = m.u - p.W * m.s;
  const SolveResult r = lemke(p);
  EXPECT_EQ(r.status, SolveStatus::kConverged) << r.message;
}

TEST(Lemke, SaysWhenAProblemHasNoSolution) {
  // A body between two walls that close in on it from both sides: u_1 + u_2 = -2 whatever s is.
  ContactProblem p{.dim = 1};
  p.A.resize(1, 1);
  p.A.insert(0, 0) = 1;
  p.H.resize(1, 2);
  p.H.insert(0, 0) = 1;
  p.H.insert(0, 1) = -1;
  p.A.makeCompressed();
  p.H.makeCompressed();
  p.v_free = Vector::Zero(1);
  p.u_free = Vector::Constant(2, -1.0);
  p.mu = Vector::Zero(2);
  const SolveResult r = lemke(p);
  EXPECT_EQ(r.status, SolveStatus::kNumericalFailure) << r.message;
  EXPECT_NE(r.message.find("a ray"), std::string::npos) << r.message;
}

TEST(Lemke, StopsAtItsLimitsAndSaysSo) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 6, 0.3, 10);
  SolverOptions options{.max_iterations = 3};
  const SolveResult few = solve("lemke", p, options);
  EXPECT_EQ(few.status, SolveStatus::kIterationLimit) << few.message;
  EXPECT_EQ(few.iterations, 3);
  options = {};
  options.time_limit = 1e-9;
  EXPECT_EQ(solve("lemke", p, options).status, SolveStatus::kTimeLimit);
  EXPECT_EQ(lemke(lattice_step(Lattice::kSquare, 13, 0.3, 0)).status, SolveStatus::kInvalidInput);
  EXPECT_EQ(lemke(manufactured_problem(3, 3, 4, 1).problem).status, SolveStatus::kInvalidInput);
}

TEST(Lemke, TakesTheSamePivotsInAnyUnits) {
  const ContactProblem p = lattice_step(Lattice::kTriangular, 4, 0.3, 10);
  const SolveResult si = lemke(in_units(p, 1, 1, 1));
  const SolveResult small = lemke(in_units(p, 1e3, 1e3, 1e3));
  ASSERT_EQ(si.status, SolveStatus::kConverged) << si.message;
  ASSERT_EQ(small.status, SolveStatus::kConverged) << small.message;
  EXPECT_EQ(si.iterations, small.iterations);
}

}  // namespace
}  // namespace bipot
