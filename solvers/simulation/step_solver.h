#pragma once

#include <string>

#include "core/base/stopwatch.h"
#include "core/motion/time_stepping.h"
#include "solvers/parallel/distributed_solve.h"
#include "solvers/solver.h"

namespace bipot {

/// A StepSolver for the time stepper: runs `entry` with `options` on every step's problem, from the
/// given start. Failed: kNumericalFailure, kDiverged; refused: kInvalidInput; cut short:
/// kTimeLimit, kInterrupted; converged: the successful statuses. Throws std::invalid_argument if the
/// solver refuses the options for every problem.
StepSolver make_step_solver(const SolverEntry& entry, SolverOptions options);

/// Converts the result of a solve for a time stepper.
StepSolution to_step_solution(SolveResult result);

/// The solver of the steps of a run, and its time.
struct RunSolver {
  std::string solver;                 ///< name
  SolverOptions options;              ///< without start and time limit
  Stopwatch watch;                    ///< since the run began
  double time_limit = kInfinity;      ///< by this watch                                   [s]
  ProcessGroup* processes = nullptr;  ///< all of these together; null: this process alone
  bool reproducible = false;          ///< exact sums: the same bits for any number of processes

  /// Throws std::invalid_argument if the solver refuses the options for every problem.
  void check() const;
  /// All processes have the same whole problem.
  SolveResult solve(const ContactProblem& problem, Vector s0) const;
  /// Each process has its part of the problem.
  PieceResult solve(const ProblemPiece& piece, const Vector& s0) const;
};

/// The stop test of that name. Throws std::invalid_argument for an unknown one.
StopTest parse_stop_test(const std::string& name);

/// Options for solve() from a scene's choice; no time limit, no start. Reads the plan of `auto`, so
/// that later changes of its file change no run. Throws as parse_stop_test and read_plan.
SolverOptions to_options(const SolverChoice& choice);

}  // namespace bipot
