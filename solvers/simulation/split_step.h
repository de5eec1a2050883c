#pragma once

#include "core/motion/time_stepping.h"

namespace bipot {

/// What a run does about a step whose problem was not solved to the tolerance.
enum class OnFailure {
  kContinue,    ///< takes it with the best impulse, and says so
  kStop,        ///< does not take it, and ends
  kSmallerStep  ///< takes it in parts (split_step.h); ends where that fails as well
};

/// Steps are halved no more often than this: 64 parts.
inline constexpr int kMostHalvings = 6;

/// A step that was taken in parts.
template <int D>
struct SplitStep {
  StepReport<D> report;
  int parts = 0;
};

/// Takes the scene's next step in two halves, each of them halved again where its problem is not solved or
/// cannot be taken, so that `state` arrives at the end of the whole step. What the parts did is added
/// up: losses, work and imbalances, iterations and times (those of parts that were halved on as well), and the impulses of each pair of bodies (core/motion/state.h),
/// so that forces are those of the whole step. The error is that of the worst part. Number and time of the step
/// are those that it has unsplit, without drift. The same state gives the same parts, so that a restart before
/// or after them goes on bit for bit.
///
/// A part of the smallest size that is not solved ends the attempt: StepFailure, and the state is as it was.
template <int D>
SplitStep<D> advance_in_parts(const Scene<D>& scene, const StepSolver& solver,
                              bool explicit_delassus, State<D>& state, int threads = 1);

/// How often the scene's next step is halved for its `travel`: least k such that no body or wall goes
/// farther in h / 2^k, at its speed before the step or at that without contacts after it; whether anything is
/// in its way is not asked. Throws StepFailure where that
/// is more than kMostTravelHalvings.
template <int D>
int travel_halvings(const Scene<D>& scene, const State<D>& state);
inline constexpr int kMostTravelHalvings = 12;  ///< 4096 parts

/// Takes the scene's next step in 2^halvings equal parts, as above. A part that is not solved is taken with the
/// best impulse (kContinue), ends the attempt (kStop) or is halved on (kSmallerStep).
template <int D>
SplitStep<D> advance_in_equal_parts(const Scene<D>& scene, const StepSolver& solver,
                                    bool explicit_delassus, State<D>& state, int halvings,
                                    OnFailure on_failure, int threads = 1);

}  // namespace bipot
