#pragma once

#include <vector>

#include "bench/tradeoff/advice.h"
#include "bench/tradeoff/sampled_problem.h"
#include "bench/tradeoff/time_budget.h"
#include "bench/tradeoff/window_run.h"

namespace bipot {

/// Windows at the recommended step, solved tightly.
struct StretchReference {
  Scene<2> scene;
  double factor = 1, window = 0, tol = 0, floor = 0;
  std::vector<const State<2>*> starts;
  std::vector<WindowRun> runs;
  /// By what as tight a run that starts its steps elsewhere differs; NaN: not run, or failed.
  Accuracy spread{kNaN, kNaN, kNaN};
};

/// Runs the windows once more, as tightly, with steps that start from s = 0 where the scene's start
/// from the step before, or the other way round. Steps with several exact answers may end on others
/// then, and those are the start of the next: what two such runs differ by no solver can promise.
void measure_spread(StretchReference& reference, const AdviseOptions& options,
                    const TimeBudget& time);

/// Runs stretches with the trials that meet the budget, cheapest first. Where one misses it, the
/// same solver at a tighter tolerance joins the trials; errors of at most half the spread count as
/// none. Ends when what is left takes much longer
/// than the best so far, or with the time.
void try_stretches(StretchReference reference, const std::vector<SampledProblem>& problems,
                   const AdviseOptions& options, const TimeBudget& time, Advice& advice);

}  // namespace bipot
