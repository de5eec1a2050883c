#pragma once

#include <limits>
#include <string>
#include <vector>

#include "core/problem/delassus.h"
#include "solvers/auto/plan.h"
#include "solvers/solver.h"

namespace bipot {

/// One stage of `auto`, and its reason. A stage ends if it meets the stop test, at
/// `max_iterations`, or if it is given up. From `min_iterations` on, the decades that the best
/// error fell over the second half of the stage are extrapolated, and must reach the tolerance
/// within `max_iterations`. Within a decade of the tolerance a stage has `near_iterations` first,
/// and from a cold start a quarter of its budget more if it will arrive by then. A stage is skipped
/// while the best error of all stages is above `largest_error`.
struct AutoStage : StageTerms {
  static constexpr int kUnlimited = std::numeric_limits<int>::max();

  const SolverEntry* solver = nullptr;
  int min_iterations = 0, max_iterations = 0, near_iterations = 0;  ///< of this stage
};

/// What a plan knows of this problem. `delassus` is the problem's; of the options start, tolerance
/// and the parameter `forces` count.
ProblemTraits traits_of(const ContactProblem& problem, const DelassusOperator& delassus,
                        const SolverOptions& options);

/// The stages that the plan has for a problem; those that this build or the problem's dimension
/// lacks are left out. Limits count iterations, not seconds: the result does not depend on the
/// machine.
std::vector<AutoStage> plan_stages(const AutoPlan& plan, const ProblemTraits& problem);

/// Those of the plan; where it has none for the problem, those of the shipped plan.
std::vector<AutoStage> serving_stages(const AutoPlan& plan, const ProblemTraits& problem);

/// The class, its odds and its stages in words, one line for each stage. Of options.plan, or
/// of the one that options.parameters name, which is read as parse_plan() does.
std::string explain_auto(const ContactProblem& problem, const SolverOptions& options);

}  // namespace bipot
