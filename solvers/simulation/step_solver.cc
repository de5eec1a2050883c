#include "solvers/simulation/step_solver.h"

#include <stdexcept>
#include <utility>
#include <vector>

#include "core/base/nearest_name.h"
#include "solvers/solve.h"

namespace bipot {

StepSolver make_step_solver(const SolverEntry& entry, SolverOptions options) {
  return [&entry, options = std::move(options)](const ContactProblem& problem, Vector s0) {
    SolverOptions from_start = options;
    from_start.s0 = std::move(s0);
    return to_step_solution(solve(entry, problem, std::move(from_start)));
  };
}

StepSolution to_step_solution(SolveResult result) {
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
}

StopTest parse_stop_test(const std::string& name) {
  std::vector<std::string> names;
  for (StopTest stop : {StopTest::kGuarded, StopTest::kRaw42, StopTest::kImpulse}) {
    if (to_string(stop) == name) return stop;
    names.emplace_back(to_string(stop));
  }
  throw std::invalid_argument(unknown_name_message("stop test", name, names));
}

SolverOptions to_options(const SolverChoice& choice) {
  SolverOptions options;
  options.tol = choice.tol;
  options.stop = parse_stop_test(choice.stop);
  options.max_iterations = choice.max_iterations;
  options.parameters = choice.parameters;
  return options;
}

}  // namespace bipot
