#include "solvers/proved_claim.h"

#include "core/criterion/extended_error.h"
#include "core/criterion/rounding_bound.h"
#include "solvers/solve.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

/// One body of 1 kg with three contacts that push to both sides, u = v, -v, v; and another that a
/// wall stops, s = 1 N s.
ContactProblem pushed_to_both_sides() {
  const Eigen::MatrixXd H{{1, -1, 1, 0}, {0, 0, 0, 1}};
  return unit_masses(1, H, Eigen::Vector2d(0, -1), Vector::Zero(4));
}

// v = 1 - 2^60 + 2^60 is 0 in double precision: all errors are 0. In truth v = 1, the third contact
// opens under its impulse, and so does the first: ε is 2^60 and more.
TEST(ProvedClaim, ASumThatRoundsAwayProvesNothing) {
  const ContactProblem p = pushed_to_both_sides();
  const double large = std::ldexp(1.0, 60);
  const Vector s = Eigen::Vector4d(1, large, large, 1);
  const ContactError error = contact_error(p, s);
  ASSERT_EQ(error.guarded(), 0);
  SolverOptions options{.tol = 1e-8};
  const ProvedClaim claim = prove_claim(p, options, s, error);
  EXPECT_FALSE(claim.holds);
  EXPECT_GT(claim.error, large);
  // The same impulses without the self-stress are an answer, and double precision proves it.
  const Vector good = Eigen::Vector4d(0, 0, 0, 1);
  const ProvedClaim proved = prove_claim(p, options, good, contact_error(p, good));
  EXPECT_TRUE(proved.holds);
  EXPECT_TRUE(std::isnan(proved.error));
}

// At the tolerance to eleven digits extended precision does not decide, and nothing is worth fifty
// times its price: the solver's next iterate will do.
TEST(ProvedClaim, AFigureAtTheToleranceIsNotProved) {
  const Manufactured m = manufactured_problem(2, 6, 9, 3);
  const Vector s = 1.001 * m.s;
  const ContactError error = contact_error(m.problem, s);
  const double figure = extended_guarded_error(m.problem, s);
  const double hidden = rounding_bound(m.problem, s, Precision::kExtended).guarded();
  ASSERT_GT(figure, 1e-6);
  ASSERT_LT(hidden, 1e-11 * figure);
  SolverOptions options{.tol = figure + 0.5 * hidden};
  EXPECT_FALSE(prove_claim(m.problem, options, s, error).holds);
  options.tol = figure + 2 * hidden;
  EXPECT_TRUE(prove_claim(m.problem, options, s, error).holds);
}

// As a start it is not taken for an answer, and does not keep solvers from one.
TEST(ProvedClaim, AStartThatOnlyRoundingSupportsIsSolvedOn) {
  SolverOptions options{.tol = 1e-8};
  const double large = std::ldexp(1.0, 60);
  options.s0 = Eigen::Vector4d(1, large, large, 1);
  const ContactProblem p = pushed_to_both_sides();
  const SolveResult r = solve("auto", p, options);
  EXPECT_NE(r.message, "the start meets the stop test");
  if (is_success(r.status)) {
    EXPECT_LE(extended_guarded_error(p, r.s), 1e-8);
  }
}

// The last thousandth of the tolerance counts: ε = 20 δ - 10 δ² for one contact of 1 kg, b = -1, s
// = 1 - δ (G = δ (1 - δ), V = δ²/2, E = 1/2), and η = sqrt(10) δ is less.
TEST(ProvedClaim, HasNoGrace) {
  const ContactProblem p = delassus_problem(1, Eigen::MatrixXd::Identity(1, 1),
                                            Vector::Constant(1, -1), Vector::Zero(1));
  const double delta = std::ldexp(1.0, -30), epsilon = 20 * delta - 10 * delta * delta;
  const Vector s = Vector::Constant(1, 1 - delta);
  const ContactError error = contact_error(p, s);
  EXPECT_NEAR(error.guarded(), epsilon, 1e-9 * epsilon);
  SolverOptions options{.tol = epsilon * (1 + 1e-3)};
  EXPECT_TRUE(prove_claim(p, options, s, error).holds);
  options.tol = epsilon * (1 - 1e-3);
  EXPECT_FALSE(prove_claim(p, options, s, error).holds);
  EXPECT_EQ(solve("pgs", p, options).status, SolveStatus::kConverged);
}

TEST(ProvedClaim, EveryConvergedAnswerAtLargeFrictionHoldsInExtendedPrecision) {
  int converged = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    for (const int dim : {2, 3}) {
      const Manufactured m = manufactured_problem(dim, 4, 4, seed, 1e6);
      const SolveResult r = solve("multistart", m.problem, {.tol = 1e-8, .time_limit = 2});
      if (!is_success(r.status)) continue;
      ++converged;
      EXPECT_LE(extended_guarded_error(m.problem, r.s), 1e-8) << "d = " << dim << ", " << seed;
    }
  }
  EXPECT_GT(converged, 6);
}

}  // namespace
}  // namespace bipot
