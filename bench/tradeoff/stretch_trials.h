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
  /// Difference of an equally tight run with other starts of its steps; NaN: not run, or failed.
  Accuracy spread{kNaN, kNaN, kNaN};
};

/// Runs the windows once more, equally tightly, with the other kind of start: s = 0 instead of the
/// previous step, or the reverse. Steps with several exact answers may then end at others, which
/// start the next step. No solver can be more accurate than the difference of two such runs.
void measure_spread(StretchReference& reference, const AdviseOptions& options,
                    const TimeBudget& time);

/// Runs stretches with the trials that meet the budget, cheapest first. If one misses it, the same
/// solver at a tighter tolerance joins the trials. Errors of at most half the spread count as zero.
/// Ends if the rest takes much longer than the best so far, or at the time limit.
void try_stretches(StretchReference reference, const std::vector<SampledProblem>& problems,
                   const AdviseOptions& options, const TimeBudget& time, Advice& advice);

}  // namespace bipot
