#include "solvers/methods/multistart_newton.h"

#include <gtest/gtest.h>

#include "solvers/solve.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

SolveResult multistart(const ContactProblem& p, double tol = 1e-11) {
  return solve("multistart", p, {.tol = tol});
}

TEST(MultistartNewton, SolvesRandomNetworksExactlyAndAgreesWithGaussSeidel) {
  int compared = 0;
  for (int dim = 1; dim <= 3; ++dim) {
    for (unsigned seed = 1; seed <= 12; ++seed) {
      const Manufactured m = manufactured_problem(dim, 8, 10, seed);
      const SolveResult exact = multistart(m.problem);
      ASSERT_EQ(exact.status, SolveStatus::kConverged) << dim << seed << exact.message;
      const SolveResult swept = solve("pgs", m.problem, {.tol = 1e-10});
      if (!is_success(swept.status)) continue;
      ++compared;
      EXPECT_LT((swept.u - exact.u).norm(), 1e-6 * m.problem.u_free.norm())
          << "d = " << dim << ", seed " << seed;
    }
  }
  EXPECT_GE(compared, 30);
}

// W = (2 -1; -1 2), b = (-1, 5). Slip to the right: s_t = -mu s_n, and u_n = 2 s_n + mu s_n - 1 = 0
// gives s_n = 1/(mu + 2), u_t = -s_n + 2 s_t + 5 = 5 - (2 mu + 1)/(mu + 2) > 0 for any mu. Sticking
// would need s_n = -1 at u = 0.
TEST(MultistartNewton, SlipsExactlyWhateverTheFriction) {
  for (const double mu : {0.1, 1.0, 1e3, 1e6, 1e9}) {
    ContactProblem p{.dim = 2};
    p.W.resize(2, 2);
    p.W.insert(0, 0) = 2;
    p.W.insert(0, 1) = -1;
    p.W.insert(1, 0) = -1;
    p.W.insert(1, 1) = 2;
    p.W.makeCompressed();
    p.u_free = (Vector(2) << -1, 5).finished();
    p.mu = Vector::Constant(1, mu);
    const SolveResult r = multistart(p, 1e-9);
    ASSERT_EQ(r.status, SolveStatus::kConverged) << mu << " " << r.message;
    EXPECT_NEAR(r.s[0] * (mu + 2), 1, 1e-9) << mu;
    EXPECT_NEAR(r.s[1], -mu / (mu + 2), 1e-9) << mu;
    EXPECT_NEAR(r.u[1], 5 - (2 * mu + 1) / (mu + 2), 1e-8) << mu;
  }
}

TEST(MultistartNewton, SolvesHyperstaticScenes) {
  const ContactProblem problems[] = {lattice_step(Lattice::kSquare, 5, 0.3, 0),
                                     lattice_step(Lattice::kTriangular, 5, 0.3, 10),
                                     lattice_step(Lattice::kPyramid, 5, 0.5, 0)};
  for (const ContactProblem& p : problems) {
    const SolveResult r = multistart(p);
    EXPECT_EQ(r.status, SolveStatus::kConverged) << p.num_contacts() << r.message;
  }
}

TEST(MultistartNewton, BeginsWithTheCallersImpulse) {
  const Manufactured m = manufactured_problem(3, 8, 10, 1);
  const SolveResult r = solve("multistart", m.problem, {.tol = 1e-11, .s0 = m.s * (1 + 1e-6)});
  ASSERT_EQ(r.status, SolveStatus::kConverged) << r.message;
  EXPECT_LE(r.iterations, 3);
}

TEST(MultistartNewton, StopsAtItsLimitsAndSaysSo) {
  const ContactProblem p = manufactured_problem(3, 12, 20, 3).problem;
  SolverOptions options{.max_iterations = 1};
  const SolveResult few = solve("multistart", p, options);
  EXPECT_EQ(few.status, SolveStatus::kIterationLimit) << few.message;
  EXPECT_EQ(few.iterations, 1);
  options = {};
  options.time_limit = 1e-9;
  EXPECT_EQ(solve("multistart", p, options).status, SolveStatus::kTimeLimit);
  options = {};
  options.tol = 1e-18;
  options.parameters = {{"starts", "1"}, {"steps_each", "1"}};
  EXPECT_EQ(solve("multistart", p, options).status, SolveStatus::kStalled);
  EXPECT_EQ(multistart(lattice_step(Lattice::kSquare, 9, 0.3, 0)).status,
            SolveStatus::kInvalidInput);
}

TEST(MultistartNewton, TakesTheSameStepsInAnyUnits) {
  const ContactProblem p = manufactured_problem(2, 8, 10, 3).problem;
  const SolveResult si = multistart(in_units(p, 1, 1, 1));
  const SolveResult small = multistart(in_units(p, 1e3, 1e3, 1e3));
  ASSERT_EQ(si.status, SolveStatus::kConverged) << si.message;
  ASSERT_EQ(small.status, SolveStatus::kConverged) << small.message;
  EXPECT_EQ(si.iterations, small.iterations);
}

}  // namespace
}  // namespace bipot
