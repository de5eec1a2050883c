#pragma once

#include "solvers/simulation/scene_run.h"

namespace bipot {

/// Largest number of halvings of a step: 64 parts.
inline constexpr int kMostHalvings = 6;

/// A step taken in parts.
template <int D>
struct SplitStep {
  StepReport<D> report;
  int parts = 0;
};

/// Takes the scene's next step in two halves. Each is halved again if its problem is not solved or
/// the step fails; `state` becomes that at the end of the whole step. The parts are reported as one
/// step (solvers/simulation/summed_parts.h). Number and time of the step are those without
/// splitting, without drift. The same state gives the same parts, so that a restart continues bit
/// for bit.
///
/// An unsolved part of the smallest size ends the attempt: StepFailure, with the state unchanged.
///
/// `options`: solver, explicit_delassus, threads, on_failure, on_tunnel. Parts in which bodies went
/// through each other are halved as well, if on_tunnel says so.
template <int D>
SplitStep<D> advance_in_parts(const Scene<D>& scene, const SceneRunOptions<D>& options,
                              State<D>& state);

/// Number of halvings of the scene's next step for its `travel`: the least k such that no body or
/// wall moves farther in h / 2^k, at its speed before the step or at that without contacts after
/// it. Obstacles are not considered. Throws StepFailure if that exceeds kMostTravelHalvings.
template <int D>
int travel_halvings(const Scene<D>& scene, const State<D>& state);
inline constexpr int kMostTravelHalvings = 12;  ///< 4096 parts

/// Takes the scene's next step in 2^halvings equal parts, as above. An unsolved part is taken with
/// the best impulse (kContinue), ends the attempt (kStop) or is halved further (kSmallerStep).
template <int D>
SplitStep<D> advance_in_equal_parts(const Scene<D>& scene, const SceneRunOptions<D>& options,
                                    State<D>& state, int halvings);

}  // namespace bipot
