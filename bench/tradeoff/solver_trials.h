#pragma once

#include <vector>

#include "bench/tradeoff/advice.h"
#include "bench/tradeoff/sampled_problem.h"
#include "bench/tradeoff/time_budget.h"

namespace bipot {

/// Solvers of this build worth a trial on problems with this number of contacts.
std::vector<SolverVariant> promising_solvers(int contacts);

/// A solver at a tolerance, with cold and with warm start.
struct TrialPair {
  SolverTrial cold, warm;
};
/// One solver at one tolerance on all problems; ends if a solve fails or takes `limit`.
TrialPair try_solver(const SolverVariant& variant, double tol,
                     const std::vector<SampledProblem>& problems, double limit,
                     const AdviseOptions& options);

/// Tries solvers from loose tolerances to tight on all problems until two of each meet the budget;
/// adds the trials to the advice.
void try_solvers(const std::vector<SampledProblem>& problems, const AdviseOptions& options,
                 const TimeBudget& time, Advice& advice);

}  // namespace bipot
