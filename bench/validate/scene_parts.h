#pragma once

#include "bench/scenes/scene_run.h"
#include "bench/validate/validation_row.h"

namespace bipot {

/// A scene of one material without bodies and walls, with the context's solver.
template <int D>
SceneIn<D> empty_scene(const ContactLaw& law, double step, double tol,
                       const ValidationContext& context);

/// A homogeneous disk (inertia m a²/2) or sphere (2/5 m a²).
template <int D>
BodyIn<D> round_body(const VecIn<D>& x, double radius, double mass);

/// The half-space above height 0, in space along z.
template <int D>
WallIn<D> flat_floor();
Wall plane_wall(const std::string& name, const Vec2& point, const Vec2& normal);

/// Steps of a scene. Those whose problem is not solved to the tolerance are taken with the best
/// impulse and counted.
template <int D>
struct ScenePartRun {
  StateIn<D> state;
  long steps = 0, unsolved = 0;
  bool stopped = false;  ///< by the context: what was measured means nothing
};

/// Takes scene.num_steps steps from `start`, or fewer where on_step returns false. Throws StepFailure
/// for a step that cannot be taken.
template <int D>
ScenePartRun<D> run_from(const SceneIn<D>& scene, StateIn<D> start,
                         const ValidationContext& context,
                         const std::function<bool(const SceneStepIn<D>&)>& on_step = {});
template <int D>
ScenePartRun<D> run_from_start(const SceneIn<D>& scene, const ValidationContext& context,
                               const std::function<bool(const SceneStepIn<D>&)>& on_step = {}) {
  return run_from<D>(scene, initial_state(scene), context, on_step);
}

/// Adds the steps of a run to an outcome; false where the context has stopped it.
template <int D>
bool count_steps(const ScenePartRun<D>& run, ExperimentOutcome& outcome) {
  outcome.steps += run.steps;
  outcome.unsolved += run.unsolved;
  return !run.stopped;
}

/// Where a property that holds from a threshold on begins, by bisection to 1e-4 of the interval; its
/// end, and a note, where it holds at `low` already or not even at `high`.
Observation find_threshold(double low, double high, const std::function<bool(double)>& holds);

}  // namespace bipot
