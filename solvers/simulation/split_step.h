#pragma once

#include "solvers/simulation/scene_run.h"

namespace bipot {

/// Largest number of halvings of an unsolved step: 64 parts.
inline constexpr int kMostHalvings = 6;
/// Iteration limit of a solve where a smaller step may follow, unless the scene has its own.
inline constexpr int kAttemptIterations = 5000;

/// A step taken in parts.
template <int D>
struct SplitStep {
  StepReport<D> report;
  int parts = 0;
  /// With which the next step begins: those of the smallest part, or one less if all parts were
  /// easy (few iterations).
  int next_halvings = 0;
};

/// Takes the scene's next step in 2^halvings equal parts; `state` becomes that at the end of the
/// whole step. The parts are reported as one step (solvers/simulation/summed_parts.h). Number and
/// time of the step are those without splitting, without drift. The same state gives the same
/// parts, so that a restart continues bit for bit.
///
/// A part that is not solved or fails is taken with the best impulse (kContinue), or halved again,
/// but not below h / 2^most_halvings: then the attempt ends with StepFailure, the state unchanged.
/// Parts in which bodies went through each other are halved likewise, if on_tunnel says so. Each
/// solve starts from the impulses of the part before, times the ratio of both lengths.
///
/// `options`: solver, threads, on_failure, on_tunnel.
template <int D>
SplitStep<D> advance_in_parts(const Scene<D>& scene, const SceneRunOptions<D>& options,
                              State<D>& state, int halvings, int most_halvings);

/// Number of halvings of the scene's next step for its `travel`: the least k such that no body or
/// wall moves farther in h / 2^k, at its speed before the step or at that without contacts after
/// it. Obstacles are not considered. Throws StepFailure if that exceeds kMostTravelHalvings.
template <int D>
int travel_halvings(const Scene<D>& scene, const State<D>& state);
inline constexpr int kMostTravelHalvings = 12;  ///< 4096 parts

}  // namespace bipot
