#pragma once

#include <chrono>

#include "core/motion/time_stepping.h"
#include "core/problem/contact_problem.h"
#include "solvers/solver.h"

namespace bipot {

/// Solves within `seconds` of CPU time (CpuLimit), which replace the options' wall time.
/// Beyond them the status of an unsolved problem is kTimeLimit.
SolveResult solve_within(const SolverEntry& entry, const ContactProblem& problem,
                         SolverOptions options, double seconds);

/// For runs that take each step, however its solve ended, unless the solver refuses it.
StepSolution taken_step(const SolveResult& result);

/// A limit on CPU time for inner loops: other work on the machine must not change the result of a
/// solver. It asks the system once in a millisecond at most.
class CpuLimit {
 public:
  /// Counts from construction. `seconds` > 0.
  explicit CpuLimit(double seconds);
  bool operator()();
  /// True if a call has reported the limit.
  bool reached() const { return reached_; }

  /// Limit on wall time, relative to the CPU limit, for loops that do not call this.
  static constexpr double kWallFactor = 20;

 private:
  using Clock = std::chrono::steady_clock;
  double end_, grain_;
  Clock::time_point asked_, read_;
  int stride_ = 1, calls_ = 0;
  bool reached_ = false;
};

/// Solves one contact, so that libraries that a solver loads at its first call (PETSc, MPI) are not
/// part of a measurement.
void warm_up(const SolverEntry& entry);

}  // namespace bipot
