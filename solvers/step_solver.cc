#include "solvers/step_solver.h"

#include "solvers/solve.h"

namespace bipot {

StepSolver make_step_solver(const SolverEntry& entry, SolverOptions options) {
  return [&entry, options = std::move(options)](const ContactProblem& problem,
                                                const Vector& s0) mutable {
    options.s0 = s0;
    SolveResult result = solve(entry, problem, options);
    StepSolution step;
    step.converged = is_success(result.status);
    step.failed =
        result.status == SolveStatus::kNumericalFailure || result.status == SolveStatus::kDiverged;
    step.refused = result.status == SolveStatus::kInvalidInput;
    step.cut_short =
        result.status == SolveStatus::kTimeLimit || result.status == SolveStatus::kInterrupted;
    step.message = std::string(to_string(result.status)) + ": " + result.message;
    step.s = std::move(result.s);
    step.error = result.error;
    step.iterations = result.iterations;
    return step;
  };
}

}  // namespace bipot
