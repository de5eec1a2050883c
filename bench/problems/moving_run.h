#pragma once

#include <functional>
#include <vector>

#include "core/base/interrupt.h"
#include "solvers/simulation/scene_run.h"

namespace bipot {

/// Runs a moving scene (moving_scene.h, moving_spheres.h) up to the last of `steps`, increasing
/// from 1. The solver is `apgd` to 1e-2 with at most kMovingIterations in each step, warm started.
/// This is fixed, so that the problems do not depend on changes of other solvers. `on_step`
/// receives those of `steps` that have contacts. Throws StepFailure, and Interrupted once
/// `cancelled` is true.
template <int D>
void run_moving_scene(const Scene<D>& scene, const std::vector<int>& steps,
                      const std::function<void(const SceneStep<D>&)>& on_step,
                      const std::function<bool()>& cancelled = &InterruptGuard::requested);

inline constexpr double kMovingTolerance = 1e-2;
inline constexpr int kMovingIterations = 1000;

}  // namespace bipot
