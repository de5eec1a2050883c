#include "tests/support/scene_run.h"

namespace bipot {

template <int D>
State<D> solved_run(const Scene<D>& scene, const OnStep<D>& on_step, const std::string& solver) {
  EXPECT_GT(scene.num_steps, 0) << "no step is checked";
  const SolverEntry& entry = require_solver(solver.empty() ? scene.solver.name : solver);
  SolverOptions options = to_options(scene.solver);
  if (!solver.empty()) options.parameters.clear();
  SceneRunOptions<D> run{.solver = make_step_solver(entry, options)};
  run.on_step = [&](const SceneStep<D>& step) {
    EXPECT_TRUE(step.report.converged)
        << "step " << step.report.step << ": " << step.report.message;
    if (on_step) on_step(step.state, step.report);
    return true;
  };
  State<D> state = initial_state(scene);
  const SceneRun<D> done = run_scene(scene, state, run);
  if (done.failure) throw *done.failure;
  return state;
}

template State<2> solved_run<2>(const Scene<2>&, const OnStep<2>&, const std::string&);
template State<3> solved_run<3>(const Scene<3>&, const OnStep<3>&, const std::string&);

}  // namespace bipot
