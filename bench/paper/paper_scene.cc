#include "bench/paper/paper_scene.h"

#include <fmt/format.h>

#include <stdexcept>

#include "bench/scenes/scene_run.h"

namespace bipot {

State run_paper_scene(const Scene& scene, const PaperContext& context,
                      const std::function<void(const State&, const StepReport&)>& on_step) {
  SceneRunOptions options;
  options.cancelled = context.interrupted;
  options.on_step = [&](const SceneStep& step) {
    if (!step.report.converged) {
      throw std::runtime_error(
          fmt::format("{}, step {}: {}", scene.title, step.report.step, step.report.message));
    }
    if (on_step) on_step(step.state, step.report);
    return true;
  };
  State state = initial_state(scene);
  const SceneRun run = run_scene(scene, state, options);
  if (run.failure) throw *run.failure;
  return state;
}

}  // namespace bipot
