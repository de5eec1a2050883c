#pragma once

#include "bench/tradeoff/advice.h"
#include "core/scene_files/scene_file.h"

namespace bipot {

/// Goal for a scene whose user has none: overlaps up to kDeepOverlap, and 5 % in means over time that
/// have a meaning in it. These are the dissipated energy, the loads on walls, and τ/P in a periodic
/// cell. Never the force on one body or an instant; nor the coordination, whose mean in a flow grows
/// with the step.
template <int D>
Accuracy default_goal(const Scene<D>& scene);

/// Tries solvers, tolerances and time steps on stretches of the scene's own run, and recommends the
/// cheapest that meets the goal. Times decide, so that two runs may differ in close cases; errors
/// do not depend on them. Throws std::invalid_argument for an inconsistent goal or options.
Advice advise(const AnyScene& scene, const Advice::Options& options);

}  // namespace bipot
