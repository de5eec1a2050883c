#pragma once

#include "bench/experiments/validation_row.h"
#include "core/scene/scene_parts.h"
#include "solvers/simulation/scene_run.h"

namespace bipot {

/// c of the inertia c m a² of a disk or a sphere.
template <int D>
constexpr double kInertia = D == 2 ? 0.5 : 0.4;

/// A scene of one material without bodies and walls, with the trial's solver.
template <int D>
Scene<D> experiment_scene(const ContactLaw& law, double step, const Experiment::Trial& trial);

/// Puts a loose filling of disks under gravity into a box from x = 0 on: floor, left and right
/// wall. Radii 0.4, 0.5 and 0.6, masses a². The height of the highest centre.
double fill_box(Scene<2>& scene, int count, double width, double spacing, std::uint64_t seed);

/// The state after scene.num_steps steps from `start`, or fewer if on_step returns false. Unsolved
/// steps are taken with the best impulse; all are counted in the trial. Throws StepFailure for a
/// failed step, and as Experiment::Trial::go_on().
template <int D>
State<D> run_from(const Scene<D>& scene, State<D> start, Experiment::Trial& trial,
                  const std::function<bool(const SceneStep<D>&)>& on_step = {});
template <int D>
State<D> run_from_start(const Scene<D>& scene, Experiment::Trial& trial,
                        const std::function<bool(const SceneStep<D>&)>& on_step = {}) {
  return run_from<D>(scene, initial_state(scene), trial, on_step);
}

/// Lower end of the range of a property that holds from a threshold on, by bisection to 1e-4 of the
/// interval. If it holds at `low` already or not even at `high`, that end and a note.
Observation find_threshold(double low, double high, const std::function<bool(double)>& holds);

}  // namespace bipot
