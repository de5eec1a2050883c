#pragma once

#include "bench/experiments/validation_row.h"
#include "core/scene/scene_parts.h"
#include "solvers/simulation/scene_run.h"

namespace bipot {

/// A scene of one material without bodies and walls, with the context's solver.
template <int D>
Scene<D> experiment_scene(const ContactLaw& law, double step, double tol,
                          const ValidationContext& context);

/// Puts a loose filling of disks under gravity into a box from x = 0 on: floor, left and right
/// wall. Radii 0.4, 0.5 and 0.6, masses a². The height of the highest centre.
double fill_box(Scene<2>& scene, int count, double width, double spacing, std::uint64_t seed);

/// Steps of a scene. Unsolved steps are taken with the best impulse and counted.
template <int D>
struct ScenePartRun {
  State<D> state;
  long steps = 0, unsolved = 0;
  bool stopped = false;  ///< by the context: the measurement is meaningless
};

/// Takes scene.num_steps steps from `start`, or fewer if on_step returns false. Throws StepFailure
/// for a failed step.
template <int D>
ScenePartRun<D> run_from(const Scene<D>& scene, State<D> start, const ValidationContext& context,
                         const std::function<bool(const SceneStep<D>&)>& on_step = {});
template <int D>
ScenePartRun<D> run_from_start(const Scene<D>& scene, const ValidationContext& context,
                               const std::function<bool(const SceneStep<D>&)>& on_step = {}) {
  return run_from<D>(scene, initial_state(scene), context, on_step);
}

/// Adds the steps of a run to an outcome; false if the context has stopped it.
template <int D>
bool count_steps(const ScenePartRun<D>& run, ExperimentOutcome& outcome) {
  outcome.steps += run.steps;
  outcome.unsolved += run.unsolved;
  return !run.stopped;
}

/// Lower end of the range of a property that holds from a threshold on, by bisection to 1e-4 of the
/// interval. If it holds at `low` already or not even at `high`, that end and a note.
Observation find_threshold(double low, double high, const std::function<bool(double)>& holds);

}  // namespace bipot
