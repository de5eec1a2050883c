#include "solvers/interior/active_set.h"

#include "core/criterion/contact_error.h"
#include "solvers/solve_run.h"
#include "tests/support/manufactured.h"
#include "tests/support/test.h"

namespace bipot {
namespace {

template <ContactRows D>
void expect_exact_from_nearby(int steps, double reached) {
  const Manufactured m =
      D.rolls ? manufactured_rolling(D, 30, 40, 3) : manufactured_problem(D, 30, 40, 3);
  const SolverOptions options{.tol = 1e-15};
  SolveRun solve(m.problem, options);
  InteriorSystem<D> system(m.problem, solve.delassus(), ShiftedDelassus::Form::kAuto);
  InteriorRun run(solve);
  ActiveSet<D> active(system);
  // Perturbed by 1e-5: the status of every contact is still decided.
  Vector s0 = m.s;
  for (int i = 0; i < s0.size(); ++i) s0[i] *= 1 + 1e-5 * (i % 3 - 1);
  EXPECT_GT(contact_error(m.problem, s0).guarded(), 1e-8);
  active.start(s0);
  active(steps, run);
  EXPECT_LT(solve.best_error(), reached) << D;
  EXPECT_LE(run.iteration, steps);
}

TEST(ActiveSet, IsExactWhereTheStatusIsKnown) {
  expect_exact_from_nearby<1>(1, 1e-11);
  expect_exact_from_nearby<2>(2, 1e-11);
  // The direction of sliding is not linear in space: Newton.
  expect_exact_from_nearby<3>(3, 1e-10);
  expect_exact_from_nearby<ContactRows(3, true)>(2, 1e-11);
  expect_exact_from_nearby<ContactRows(6, true)>(3, 1e-10);
}

}  // namespace
}  // namespace bipot
