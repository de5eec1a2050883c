#pragma once

#include "core/motion/time_stepping.h"
#include "solvers/solver.h"

namespace bipot {

/// A StepSolver for the time stepper: runs `entry` with `options` on every step's problem, from the
/// start that the stepper hands over. Failed: kNumericalFailure, kDiverged; refused: kInvalidInput;
/// cut short: kTimeLimit, kInterrupted; converged: the successful statuses.
StepSolver make_step_solver(const SolverEntry& entry, SolverOptions options);

/// What a time stepper is told of a solve.
StepSolution to_step_solution(SolveResult result);

/// The stop test of that name. Throws std::invalid_argument for an unknown one.
StopTest parse_stop_test(const std::string& name);

/// Options for solve() from a scene's choice; no time limit, no start. Throws as parse_stop_test.
SolverOptions to_options(const SolverChoice& choice);

}  // namespace bipot
