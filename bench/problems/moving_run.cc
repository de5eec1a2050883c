#include "bench/problems/moving_run.h"

#include <algorithm>

#include "core/base/interrupt.h"
#include "solvers/registry.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {

template <int D>
void run_moving_scene(const Scene<D>& scene, const std::vector<int>& steps,
                      const std::function<void(const SceneStep<D>&)>& on_step,
                      const std::function<bool()>& cancelled) {
  if (steps.empty()) return;
  SolverOptions options{
      .tol = kMovingTolerance, .max_iterations = kMovingIterations, .cancelled = cancelled};
  State<D> state = initial_state(scene);
  SceneRunOptions<D> to_last;
  to_last.steps = steps.back();
  to_last.solver = make_step_solver(require_solver("apgd"), options);
  to_last.on_step = [&](const SceneStep<D>& step) {
    const bool wanted = std::binary_search(steps.begin(), steps.end(), step.report.step);
    if (wanted && step.problem.num_contacts() > 0) on_step(step);
    return true;
  };
  to_last.cancelled = options.cancelled;
  const SceneRun<D> done = run_scene(scene, state, to_last);
  if (cancelled()) throw Interrupted();
  if (done.failure) throw *done.failure;
}

template void run_moving_scene<2>(const Scene<2>&, const std::vector<int>&,
                                  const std::function<void(const SceneStep<2>&)>&,
                                  const std::function<bool()>&);
template void run_moving_scene<3>(const Scene<3>&, const std::vector<int>&,
                                  const std::function<void(const SceneStep<3>&)>&,
                                  const std::function<bool()>&);

}  // namespace bipot
