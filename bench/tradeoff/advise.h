#pragma once

#include "bench/tradeoff/advice.h"
#include "core/scene/scene.h"

namespace bipot {

/// Tries solvers, tolerances and time steps on the scene's own steps, and recommends the cheapest
/// that meets the goal. Times decide, so that two runs may differ in close cases; errors do not
/// depend on them. Throws std::invalid_argument for an inconsistent goal or options.
Advice advise(const Scene<2>& scene, const AdviseOptions& options);

}  // namespace bipot
