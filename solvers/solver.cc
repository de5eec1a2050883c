#include "solvers/solver.h"

#include <array>

namespace bipot {

std::string_view to_string(SolveStatus status) {
  static constexpr std::array<std::string_view, 10> kNames = {
      "not run",     "converged", "nothing to do", "iteration limit",   "time limit",
      "interrupted", "stalled",   "diverged",      "numerical failure", "invalid input"};
  return kNames.at(static_cast<std::size_t>(status));
}

bool is_success(SolveStatus status) {
  return status == SolveStatus::kConverged || status == SolveStatus::kNothingToDo;
}

std::string_view to_string(StopTest stop) {
  static constexpr std::array<std::string_view, 3> kNames = {"guarded", "raw42", "impulse"};
  return kNames.at(static_cast<std::size_t>(stop));
}

bool meets(const SolverOptions& options, const ContactError& error) {
  if (options.stop == StopTest::kImpulse) return false;
  return (options.stop == StopTest::kRaw42 ? error.raw42 : error.guarded()) <= options.tol;
}

Vector start_of(const ContactProblem& problem, const SolverOptions& options) {
  if (options.s0.size() != 0) return options.s0;
  return Vector::Zero(problem.num_rows());
}

bool is_warm(const SolverOptions& options) {
  return options.s0.size() != 0 && options.s0.squaredNorm() > 0;
}

}  // namespace bipot
