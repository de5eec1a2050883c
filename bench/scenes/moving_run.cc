#include "bench/scenes/moving_run.h"

#include <algorithm>

#include "solvers/registry.h"
#include "solvers/step_solver.h"

namespace bipot {

void run_moving_scene(const Scene& scene, const std::vector<int>& steps,
                      const std::function<void(const SceneStep&)>& on_step) {
  if (steps.empty()) return;
  SolverOptions options;
  options.tol = kMovingTolerance;
  options.max_iterations = kMovingIterations;
  State state = initial_state(scene);
  SceneRunOptions to_last;
  to_last.steps = steps.back();
  to_last.solver = make_step_solver(require_solver("apgd"), options);
  to_last.on_step = [&](const SceneStep& step) {
    const bool wanted = std::binary_search(steps.begin(), steps.end(), step.report.step);
    if (wanted && step.problem.num_contacts() > 0) on_step(step);
    return true;
  };
  const SceneRun done = run_scene(scene, state, to_last);
  if (done.failure) throw *done.failure;
}

}  // namespace bipot
