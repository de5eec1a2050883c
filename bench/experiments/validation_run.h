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

/// Runs the experiment at each of its tolerances; its exceptions become part of the points.
/// `on_tolerance`: called before each, with the number of finished ones and of all.
ExperimentResult run_experiment(const ValidationExperiment& experiment,
                                const ValidationContext& context,
                                const std::function<void(int done, int total)>& on_tolerance = {});

}  // namespace bipot
