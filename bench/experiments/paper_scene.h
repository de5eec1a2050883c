#pragma once

#include <functional>

#include "bench/experiments/paper_item.h"
#include "core/motion/time_stepping.h"

namespace bipot {

/// Runs a scene with its own solver choice, step by step, and returns the last state. A step that
/// does not meet the scene's tolerance throws std::runtime_error with the solver's message. Stops
/// early when the context is interrupted.
State<2> run_paper_scene(
    const Scene<2>& scene, const PaperContext& context,
    const std::function<void(const State<2>&, const StepReport<2>&)>& on_step = {});

}  // namespace bipot
