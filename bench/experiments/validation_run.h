#pragma once

#include <functional>
#include <vector>

#include "bench/experiments/validation_row.h"

namespace bipot {

struct ExperimentResult {
  std::vector<ValidationRow> rows;   ///< judged
  std::vector<ClaimFigure> figures;  ///< of the tightest tolerance that gave some
  bool complete = true;              ///< false: the context stopped it
};

/// The experiment at each of its tolerances. What it throws at one of them stands in the points.
/// `on_tolerance`: before each, how many are done and how many there are.
ExperimentResult run_experiment(const ValidationExperiment& experiment,
                                const ValidationContext& context,
                                const std::function<void(int done, int total)>& on_tolerance = {});

}  // namespace bipot
