#include "bench/problems/moving_run.h"

#include <algorithm>

#include "solvers/registry.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {

void run_moving_scene(const Scene<2>& scene, const std::vector<int>& steps,
                      const std::function<void(const SceneStep<2>&)>& on_step) {
  if (steps.empty()) return;
  SolverOptions options{.tol = kMovingTolerance, .max_iterations = kMovingIterations};
  State<2> state = initial_state(scene);
  SceneRunOptions<2> to_last;
  to_last.steps = steps.back();
  to_last.solver = make_step_solver(require_solver("apgd"), options);
  to_last.on_step = [&](const SceneStep<2>& step) {
    const bool wanted = std::binary_search(steps.begin(), steps.end(), step.report.step);
    if (wanted && step.problem.num_contacts() > 0) on_step(step);
    return true;
  };
  const SceneRun<2> done = run_scene(scene, state, to_last);
  if (done.failure) throw *done.failure;
}

}  // namespace bipot
