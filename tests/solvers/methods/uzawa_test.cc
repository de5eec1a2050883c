#include "solvers/methods/uzawa.h"

#include "tests/support/converged.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/small_problems.h"

namespace bipot {
namespace {

SolveResult run_uzawa(const std::string& solver, const ContactProblem& p,
                      std::map<std::string, std::string> parameters, SolverOptions o = {}) {
  o.parameters = std::move(parameters);
  return solve(solver, p, o);
}

// One iteration by hand: W = diag(2, 5), mu = 0.5, b = (-4, 3), rho = 1/2 from s = 0. De Saxcé's
// velocity is (-4 + 0.5·3, 3) = (-2.5, 3), tau = (1.25, -1.5), outside the cone; (34) gives
// s_n = (1.25 + 0.5·1.5)/1.25 = 1.6, s_t = -0.8. The classical way takes the normal part first:
// s_n = max(0, 0 + 4/2) = 2, then s_t = -3/2 is cut off at mu s_n = 1.
TEST(Uzawa, PaperStepIsFormula41AndTheClassicalOneTakesTheNormalPartFirst) {
  const ContactProblem p = one_contact_problem(2, 2, 5, 0.5, -4, Vector::Constant(1, 3));
  for (const auto& [solver, s] :
       {std::pair("uzawa", Vector{{1.6, -0.8}}), std::pair("classical", Vector{{2, -1}})}) {
    double epsilon = 0;
    const auto keep = [&](const IterationRecord& r) {
      if (r.iteration == 1) epsilon = r.error.epsilon;
    };
    run_uzawa(solver, p, {{"rho", "paper"}},
              {.tol = 1e-15, .max_iterations = 1, .on_iteration = keep});
    EXPECT_NEAR(epsilon, contact_error(p, s).epsilon, 1e-12) << solver;
  }
}

// rho W_tt = 3 > 2 on sticking contacts: the paper's step leaves the stable range.
TEST(Uzawa, ThePapersStepFailsWhereDisksStick) {
  const ContactProblem p = triangular_lattice(6, {.tilt = 0.17});
  SolverOptions o{.tol = 1e-2, .max_iterations = 20000};
  for (const std::string solver : {"uzawa", "classical"}) {
    for (const std::string refresh : {"jacobi", "gauss-seidel"}) {
      const SolveResult r = run_uzawa(solver, p, {{"rho", "paper"}, {"refresh", refresh}}, o);
      EXPECT_FALSE(is_success(r.status)) << solver << refresh << r.message;
      EXPECT_NE(r.status, SolveStatus::kNumericalFailure) << solver << refresh << r.message;
      EXPECT_GT(r.error.guarded(), 0.1) << solver << refresh;
      EXPECT_TRUE(r.s.allFinite());
      EXPECT_EQ(run_uzawa(solver, p, {{"refresh", refresh}}, o).status, SolveStatus::kConverged);
    }
  }
}

// The classical stop test is met long before the law holds: the iterates creep on a lattice.
TEST(Classical, ItsOwnStopTestIsMetEarly) {
  const ContactProblem p = square_lattice(12);
  SolverOptions o{.tol = 1e-2, .stop = StopTest::kImpulse};
  const SolveResult impulse = converged(run_uzawa("classical", p, {}, o));
  EXPECT_GT(impulse.error.guarded(), 10 * o.tol);
  o.stop = StopTest::kGuarded;
  EXPECT_GT(converged(run_uzawa("classical", p, {}, o)).iterations, impulse.iterations);
}

}  // namespace
}  // namespace bipot
