#include "bench/experiments/paper_scene.h"

#include <fmt/format.h>

#include <stdexcept>

#include "solvers/simulation/scene_run.h"

namespace bipot {

State<2> run_paper_scene(
    const Scene<2>& scene, const PaperContext& context,
    const std::function<void(const State<2>&, const StepReport<2>&)>& on_step) {
  SceneRunOptions<2> options;
  options.cancelled = context.interrupted;
  options.on_step = [&](const SceneStep<2>& step) {
    if (!step.report.converged) {
      throw std::runtime_error(
          fmt::format("{}, step {}: {}", scene.title, step.report.step, step.report.message));
    }
    if (on_step) on_step(step.state, step.report);
    return true;
  };
  State<2> state = initial_state(scene);
  const SceneRun<2> run = run_scene(scene, state, options);
  if (run.failure) throw *run.failure;
  return state;
}

}  // namespace bipot
