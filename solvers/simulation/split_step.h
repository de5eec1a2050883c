#pragma once

#include "solvers/simulation/scene_run.h"

namespace bipot {

/// Steps are halved no more often than this: 64 parts.
inline constexpr int kMostHalvings = 6;

/// A step that was taken in parts.
template <int D>
struct SplitStep {
  StepReport<D> report;
  int parts = 0;
};

/// Takes the scene's next step in two halves. Each is halved again where its problem is not solved
/// or it cannot be taken; `state` arrives at the end of the whole step. Losses, work, imbalances,
/// iterations, times and the impulses of each pair of bodies (core/motion/state.h) are summed over
/// the parts, so that forces are those of the whole step. The cost of parts that were not taken
/// counts as well. The error is that of the worst part. Number and time of the step are those that
/// it has unsplit, without drift. The same state gives the same parts, so that a restart before or
/// after them goes on bit for bit.
///
/// A part of the smallest size that is not solved ends the attempt: StepFailure, and the state is
/// as it was.
template <int D>
SplitStep<D> advance_in_parts(const Scene<D>& scene, const StepSolver& solver,
                              bool explicit_delassus, State<D>& state, int threads = 1);

/// How often the scene's next step is halved for its `travel`: least k such that no body or wall
/// goes farther in h / 2^k, at its speed before the step or at that without contacts after it;
/// whether anything is in its way is not asked. Throws StepFailure where that is more than
/// kMostTravelHalvings.
template <int D>
int travel_halvings(const Scene<D>& scene, const State<D>& state);
inline constexpr int kMostTravelHalvings = 12;  ///< 4096 parts

/// Takes the scene's next step in 2^halvings equal parts, as above. A part that is not solved is
/// taken with the best impulse (kContinue), ends the attempt (kStop) or is halved on
/// (kSmallerStep).
template <int D>
SplitStep<D> advance_in_equal_parts(const Scene<D>& scene, const StepSolver& solver,
                                    bool explicit_delassus, State<D>& state, int halvings,
                                    OnFailure on_failure, int threads = 1);

}  // namespace bipot
