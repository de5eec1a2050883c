#include "solvers/methods/anderson.h"

#include "tests/support/converged.h"
#include "tests/support/lattice_problem.h"
#include "tests/support/manufactured.h"

namespace bipot {
namespace {

SolveResult run_accelerated(const std::string& solver, const ContactProblem& p,
                            std::map<std::string, std::string> parameters = {}) {
  return solve(solver, p, {.max_iterations = 100000, .parameters = std::move(parameters)});
}

TEST(Anderson, BeatsTheSweepsItAccelerates) {
  for (const ContactProblem& p : {square_lattice(16), cubic_lattice(5)}) {
    const SolveResult plain = converged(run_accelerated("pgs", p, {{"order", "symmetric"}})),
                      fast = converged(run_accelerated("anderson", p));
    // An iteration of anderson is a forward and a backward sweep.
    EXPECT_LT(2 * 2 * fast.iterations, plain.iterations) << p.dim;
  }
}

TEST(Anderson, MoreMemoryThanIterationsIsNoHarm) {
  const ContactProblem p = manufactured_problem(2, 6, 6, 3).problem;
  converged(run_accelerated("anderson", p, {{"memory", "100"}}));
}

// One column of memory is the secant method: it converges, and not faster than eight columns.
TEST(Anderson, MemoryHelps) {
  const ContactProblem p = square_lattice(16);
  const SolveResult one = converged(run_accelerated("anderson", p, {{"memory", "1"}})),
                    eight = converged(run_accelerated("anderson", p));
  EXPECT_LT(eight.iterations, one.iterations);
}

}  // namespace
}  // namespace bipot
