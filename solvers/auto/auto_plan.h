#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/problem/delassus.h"
#include "solvers/solver.h"

namespace bipot {

/// One stage of `auto`, and its reason. A stage ends if it meets the stop test, at
/// `max_iterations`, or if it is given up. From `min_iterations` on, the decades that the best
/// error fell over the second half of the stage are extrapolated, and must reach the tolerance
/// within `max_iterations`. Within a decade of the tolerance a stage has `near_iterations` first. A
/// stage is skipped while the best error of all stages is above `largest_error`.
struct AutoStage {
  /// A stage starts at the impulse of the same solver's last stage (at first, at the caller's
  /// start), at the caller's start, at the impulse of the last stage, or at the best one.
  enum class Start { kOwn, kCaller, kLast, kBest };
  static constexpr int kUnlimited = std::numeric_limits<int>::max();

  std::string_view solver;
  std::string_view parameters;  ///< "name=value name=value"
  Start start = Start::kOwn;
  double of_start = 1;                                              ///< factor of that impulse
  int min_iterations = 0, max_iterations = 0, near_iterations = 0;  ///< of this stage
  double largest_error = kInfinity;
  bool before_cutting = false;  ///< tried on the whole before it is split into islands
  bool on_whole_only = false;   ///< then not tried again on islands
  std::string_view reason;
};

/// The stages for this problem from its size, form and masses, by the tables of plan_tables.h.
/// Limits count iterations, not seconds: the result does not depend on the machine. `delassus` is
/// the problem's; `warm`: the caller's start is not 0.
std::vector<AutoStage> plan_auto(const ContactProblem& problem, const DelassusOperator& delassus,
                                 bool warm, double tol);

/// The plan in words, one line for each stage.
std::string explain_auto(const ContactProblem& problem, const SolverOptions& options);

}  // namespace bipot
