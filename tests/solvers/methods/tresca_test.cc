#include "solvers/methods/tresca.h"

#include "tests/support/converged.h"
#include "tests/support/lattice_problem.h"

namespace bipot {
namespace {

/// W = (1 1/2; 1/2 1), b = (-1, -10): it slides, s_t = g. With a bound g held, 0 = u_n = s_n + g/2 -
/// 1, so that the next bound is mu (1 - g/2)₊.
ContactProblem coupled(double mu) {
  return {.dim = 2,
          .W = Eigen::MatrixXd{{1, 0.5}, {0.5, 1}}.sparseView(),
          .u_free = Vector{{-1, -10}},
          .mu = Vector::Constant(1, mu)};
}

// mu = 1: the bounds approach 2/3 by factors of -1/2.
TEST(Tresca, BoundsApproachThoseOfCoulombsLaw) {
  const SolveResult r = converged(solve("tresca", coupled(1), {.tol = 1e-12}));
  EXPECT_NEAR(r.s[0], 2.0 / 3, 1e-11);
  EXPECT_NEAR(r.s[1], 2.0 / 3, 1e-11);
  EXPECT_TRUE(says(r.message, "sets of bounds"));
}

// Without friction the bounds are 0 and stand: a slow start is no cycle.
TEST(Tresca, BoundsThatStandKeepTheMomentum) {
  const ContactProblem p = square_lattice(40, {.mu = 0});
  const int plain = converged(solve("apgd", p, {.tol = 1e-3})).iterations;
  EXPECT_LT(converged(solve("tresca", p, {.tol = 1e-3})).iterations, 3 * plain);
}

// mu = 3: the bounds are 0, 3, 0, 3, ... Coulomb's law has the solution s_n = 2/5, s_t = 6/5.
TEST(Tresca, SaysThatItsBoundsCycle) {
  const ContactProblem p = coupled(3);
  const SolveResult r =
      ended(SolveStatus::kStalled, solve("tresca", p, {.max_iterations = 100000}));
  EXPECT_TRUE(says(r.message, "the bounds of friction do not settle"));
  EXPECT_NEAR(solve("pgs", p, {.parameters = {{"local", "exact"}}}).s[0], 0.4, 1e-7);
}

}  // namespace
}  // namespace bipot
