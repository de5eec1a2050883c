#include "solvers/methods/multistart_newton.h"

#include "tests/support/converged.h"
#include "tests/support/manufactured.h"

namespace bipot {
namespace {

SolveResult multistart(const ContactProblem& p, double tol = 1e-11) {
  return solve("multistart", p, {.tol = tol});
}

// W = (2 -1; -1 2), b = (-1, 5). Slip to the right: s_t = -mu s_n, and u_n = 2 s_n + mu s_n - 1 = 0
// gives s_n = 1/(mu + 2), u_t = -s_n + 2 s_t + 5 = 5 - (2 mu + 1)/(mu + 2) > 0 for any mu. Sticking
// would need s_n = -1 at u = 0.
TEST(MultistartNewton, SlipsExactlyWhateverTheFriction) {
  for (const double mu : {0.1, 1.0, 1e3, 1e6, 1e9}) {
    const ContactProblem p{.dim = 2,
                           .W = Eigen::MatrixXd{{2, -1}, {-1, 2}}.sparseView(),
                           .u_free = Vector{{-1, 5}},
                           .mu = Vector::Constant(1, mu)};
    const SolveResult r = converged(multistart(p, 1e-9), mu);
    EXPECT_NEAR(r.s[0] * (mu + 2), 1, 1e-9) << mu;
    EXPECT_NEAR(r.s[1], -mu / (mu + 2), 1e-9) << mu;
    EXPECT_NEAR(r.u[1], 5 - (2 * mu + 1) / (mu + 2), 1e-8) << mu;
  }
}

TEST(MultistartNewton, BeginsWithTheCallersImpulse) {
  const Manufactured m = manufactured_problem(3, 8, 10, 1);
  const SolveResult r =
      converged(solve("multistart", m.problem, {.tol = 1e-11, .s0 = m.s * (1 + 1e-6)}));
  EXPECT_LE(r.iterations, 3);
}

TEST(MultistartNewton, SaysThatItsStartsAreUsedUp) {
  const ContactProblem p = manufactured_problem(3, 12, 20, 3).problem;
  ended(
      SolveStatus::kStalled,
      solve("multistart", p, {.tol = 1e-18, .parameters = {{"starts", "1"}, {"steps_each", "1"}}}));
}

}  // namespace
}  // namespace bipot
