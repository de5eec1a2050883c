#include "solvers/solver.h"

#include <fmt/format.h>

#include <array>

#include "solvers/registry.h"

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

std::string beyond_solver(const SolverEntry& entry, const ContactProblem& p) {
  if (p.rolls() && !entry.rolls) {
    std::string able;
    for (const SolverEntry& other : solver_table()) {
      if (other.rolls) able += (able.empty() ? "" : ", ") + std::string(other.name);
    }
    return fmt::format("solver {} has no rolling friction; those that have it: {}", entry.name,
                       able);
  }
  if (p.plain_dim() > entry.max_dim) {
    return fmt::format("solver {} handles contact dimensions up to {}, the problem has {}",
                       entry.name, entry.max_dim, p.dim);
  }
  if (p.num_contacts() > entry.max_contacts) {
    return fmt::format("solver {} handles at most {} contacts, the problem has {}", entry.name,
                       entry.max_contacts, p.num_contacts());
  }
  return {};
}

Vector start_of(const ContactProblem& problem, const SolverOptions& options) {
  if (options.s0.size() != 0) return options.s0;
  return Vector::Zero(problem.num_rows());
}

bool is_warm(const SolverOptions& options) {
  return options.s0.size() != 0 && options.s0.squaredNorm() > 0;
}

}  // namespace bipot
