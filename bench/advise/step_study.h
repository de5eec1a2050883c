#pragma once

#include <map>
#include <vector>

#include "bench/advise/advice.h"
#include "bench/advise/time_budget.h"
#include "bench/advise/window_run.h"

namespace bipot {

/// A study with the runs behind it.
struct StepRuns {
  StepStudy study;
  std::vector<const State*> starts;               ///< of the windows that were kept
  std::map<double, std::vector<WindowRun>> runs;  ///< by factor, in the order of `starts`
  double floor = 0;                               ///< energy_floor of all windows
};

/// Measures time steps on windows from these states, as many of both as time allows; what is
/// dropped first stands last. The states must outlive the result.
StepRuns study_steps(const Scene& scene, const std::vector<const State*>& starts,
                     const AdviseOptions& options, const TimeBudget& time);

}  // namespace bipot
