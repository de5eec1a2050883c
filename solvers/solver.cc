#include "solvers/solver.h"

namespace bipot {

std::string_view to_string(SolveStatus status) {
  switch (status) {
    case SolveStatus::kNotRun:
      return "not run";
    case SolveStatus::kConverged:
      return "converged";
    case SolveStatus::kNothingToDo:
      return "nothing to do";
    case SolveStatus::kIterationLimit:
      return "iteration limit";
    case SolveStatus::kTimeLimit:
      return "time limit";
    case SolveStatus::kInterrupted:
      return "interrupted";
    case SolveStatus::kStalled:
      return "stalled";
    case SolveStatus::kDiverged:
      return "diverged";
    case SolveStatus::kNumericalFailure:
      return "numerical failure";
    case SolveStatus::kInvalidInput:
      return "invalid input";
  }
  return "unknown status";
}

bool is_success(SolveStatus status) {
  return status == SolveStatus::kConverged || status == SolveStatus::kNothingToDo;
}

std::string_view to_string(StopTest stop) {
  switch (stop) {
    case StopTest::kGuarded:
      return "guarded";
    case StopTest::kRaw42:
      return "raw42";
    case StopTest::kImpulse:
      return "impulse";
  }
  return "unknown stop test";
}

bool meets(const SolverOptions& options, const ContactError& error) {
  switch (options.stop) {
    case StopTest::kGuarded:
      return error.guarded() <= options.tol;
    case StopTest::kRaw42:
      return error.raw42 <= options.tol;
    case StopTest::kImpulse:
      return false;
  }
  return false;
}

Vector start_of(const ContactProblem& problem, const SolverOptions& options) {
  if (options.s0.size() != 0) return options.s0;
  return Vector::Zero(problem.num_rows());
}

bool is_warm(const SolverOptions& options) {
  return options.s0.size() != 0 && options.s0.squaredNorm() > 0;
}

}  // namespace bipot
