#include "solvers/methods/pdas.h"

#include "tests/support/converged.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

// W = 1, mu = 1/2. Taking off, sticking and sliding contacts, with s by hand: see
// one_contact_problem(). From s = 0, where z = -kappa b, the sets are those of the solution, so that
// each regularised problem takes one solve. With kappa = 1e7 the first of them leaves an error of
// 1/(1 + kappa) of the impulse, the second one of its square.
TEST(Pdas, SolvesOnceForEachSetOfOneContact) {
  struct Known {
    double b_n, b_t, s_n, s_t;
  };
  for (const Known& k : {Known{-1, 0.25, 1, -0.25}, Known{-1, 4, 1, -0.5}, Known{-1, -4, 1, 0.5}}) {
    const ContactProblem p = one_contact_problem(2, 1, 1, 0.5, k.b_n, Vector{{k.b_t}});
    const SolveResult r =
        converged(solve("pdas", p, {.tol = 1e-11, .parameters = {{"kappa", "1e7"}}}));
    EXPECT_LE(r.iterations, 2);
    EXPECT_NEAR(r.s[0], k.s_n, 1e-11);
    EXPECT_NEAR(r.s[1], k.s_t, 1e-11);
  }
}

// One change of the sets can never be confirmed by a second look, and the least kappa, 1e-3, leaves
// no smaller one: the first failure is the end.
TEST(Pdas, SaysThatTheSetsDoNotSettle) {
  const ContactProblem p = manufactured_problem(2, 20, 24, 7).problem;
  const SolveResult r =
      ended(SolveStatus::kStalled,
            solve("pdas", p, {.parameters = {{"set_changes", "1"}, {"kappa", "1e-3"}}}));
  EXPECT_TRUE(says(r.message, "the sets still change after 1 solves"));
  EXPECT_GT(r.error.guarded(), 1e-2);
}

}  // namespace
}  // namespace bipot
