#pragma once

#include <functional>
#include <span>

#include "solvers/auto/auto_plan.h"
#include "solvers/solve_run.h"

namespace bipot {

/// Runs the stages that `chosen` selects in turn until one meets the stop test; the message says
/// which ones ran, how they ended and which one succeeded. No stage is hidden: when all fail, the
/// status is that of the last one and the impulse the best one. `iterations` is
/// the sum over stages, whose iterations differ much in cost. `best`: an impulse that competes with
/// the caller's start, or empty. Without a stage the result has no status.
SolveResult race_stages(SolveRun& run, std::span<const AutoStage> stages, const Vector& best,
                        const std::function<bool(const AutoStage&)>& chosen);

}  // namespace bipot
