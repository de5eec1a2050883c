#include "solvers/simulation/step_solver.h"

#include <algorithm>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/nearest_name.h"
#include "solvers/auto/plan.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

/// A run shows its forces, and later steps start from them.
SolverOptions in_a_run(SolverOptions options, std::string_view solver) {
  if (solver == "auto") options.parameters.try_emplace("forces", "spread");
  return options;
}

SolveResult solve_with(const RunSolver& run, const ContactProblem& problem, SolverOptions options,
                       ProcessGroup* processes) {
  if (processes == nullptr) return bipot::solve(run.solver, problem, std::move(options));
  return distributed_solve(run.solver, problem, options, *processes,
                           {.reproducible = run.reproducible})
      .result;
}

/// Options of a step that begins now.
SolverOptions options_now(const RunSolver& run, Vector s0) {
  SolverOptions options = in_a_run(run.options, run.solver);
  options.time_limit = std::max(run.time_limit - run.watch.seconds(), 1e-3);
  options.s0 = std::move(s0);
  return options;
}

/// Throws std::invalid_argument if no problem could be solved so. `probe`: of a problem without
/// contacts.
void require_not_refused(const SolveResult& probe) {
  if (probe.status == SolveStatus::kInvalidInput) throw std::invalid_argument(probe.message);
}

}  // namespace

StepSolver make_step_solver(const SolverEntry& entry, SolverOptions options) {
  options = in_a_run(std::move(options), entry.name);
  require_not_refused(solve(entry, ContactProblem{}, options));
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
  step.message = to_string(result.status);
  const bool said = result.message.starts_with(step.message);
  if (!step.cut_short) step.message = said ? result.message : step.message + ": " + result.message;
  step.s = std::move(result.s);
  step.error = result.error;
  step.iterations = result.iterations;
  return step;
}

void RunSolver::check() const {
  const auto lone = processes != nullptr ? lone_process() : nullptr;
  require_not_refused(solve_with(*this, ContactProblem{}, options, lone.get()));
}

SolveResult RunSolver::solve(const ContactProblem& problem, Vector s0) const {
  return solve_with(*this, problem, options_now(*this, std::move(s0)), processes);
}

PieceResult RunSolver::solve(const ProblemPiece& piece, const Vector& s0) const {
  return distributed_solve(solver, piece, options_now(*this, s0), *processes,
                           {.reproducible = reproducible});
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
  return {.tol = choice.tol,
          .stop = parse_stop_test(choice.stop),
          .max_iterations = choice.max_iterations,
          .parameters = choice.parameters,
          .plan = named_plan(choice.parameters)};
}

}  // namespace bipot
