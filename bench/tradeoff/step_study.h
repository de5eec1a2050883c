#pragma once

#include <map>
#include <vector>

#include "bench/tradeoff/advice.h"
#include "bench/tradeoff/time_budget.h"
#include "bench/tradeoff/window_run.h"

namespace bipot {

/// A study with its runs.
struct StepRuns {
  StepStudy study;
  std::vector<const State<2>*> starts;            ///< of the windows that were kept
  std::map<double, std::vector<WindowRun>> runs;  ///< by factor, in the order of `starts`
  double floor = 0;                               ///< energy_floor of all windows
};

/// Measures time steps on windows from these states, as many of both as time allows. If time runs
/// out, the last ones are dropped. The states must outlive the result.
StepRuns study_steps(const Scene<2>& scene, const std::vector<const State<2>*>& starts,
                     const AdviseOptions& options, const TimeBudget& time);

}  // namespace bipot
