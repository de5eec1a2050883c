#include "solvers/methods/pseudo_transient.h"

#include "tests/support/converged.h"
#include "tests/support/manufactured.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

// W = 1, mu = 1/2, b = (-1, b_t): s_n = 1, and the friction is -b_t within its bound, else 1/2. Both
// equations are linear, so that a step solves that of its anchor. Its error is d/(1 + d) of the one
// before, d = delta or 5 delta (tangents), delta = 0.1, 0.01, ... 1e-6: below 1e-12 after six steps.
TEST(PseudoTransient, SolvesOneContactInAStepForEachDelta) {
  for (const auto& [b_t, s_t] :
       {std::pair(0.05, -0.05), std::pair(4.0, -0.5), std::pair(-4.0, 0.5)}) {
    const ContactProblem p = one_contact_problem(2, 1, 1, 0.5, -1, Vector{{b_t}});
    const SolveResult r = converged(solve("ptc", p, {.tol = 1e-12}));
    EXPECT_LE(r.iterations, 6);
    EXPECT_NEAR(r.s[0], 1, 1e-12);
    EXPECT_NEAR(r.s[1], s_t, 1e-12);
  }
}

// From an error of some 1e-3 steps converge superlinearly: a hundred contacts, more rows than
// degrees of freedom, known velocity.
TEST(PseudoTransient, EndsWhatSweepsBegan) {
  const Manufactured known = manufactured_problem(3, 40, 100, 3);
  const SolveResult start = converged(solve("pgs", known.problem, {.tol = 1e-3}));
  const SolveResult r = converged(solve("ptc", known.problem, {.tol = 1e-12, .s0 = start.s}));
  EXPECT_LE(r.iterations, 30);
  EXPECT_LE((r.u - known.u).norm(), 1e-8 * known.problem.u_free.norm());
}

// Below rounding no tolerance is met, and the solver says so.
TEST(PseudoTransient, StopsWhereRoundingForbidsMore) {
  const ContactProblem p = manufactured_problem(3, 20, 40, 5).problem;
  const SolveResult r = ended(SolveStatus::kStalled, solve("ptc", p, {.tol = 1e-30}));
  EXPECT_TRUE(says(r.message, "no step helps")) << r.message;
  EXPECT_LT(r.error.guarded(), 1e-9);
}

}  // namespace
}  // namespace bipot
