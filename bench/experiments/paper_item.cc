#include "bench/experiments/paper_item.h"

#include <fmt/format.h>

#include "solvers/simulation/scene_run.h"

namespace bipot {

const std::vector<PaperItem>& paper_items() {
  static const std::vector<PaperItem> items = {
      {"table1", "Table 1: bouncing ball", run_table1},
      {"table2", "Table 2: sliding cylinder", run_table2},
      {"fig10", "Fig. 10: quasi-static arrays", run_fig10},
      {"fig11", "Fig. 11: compaction by gravity", run_fig11},
      {"fig12", "Fig. 12: isotropic compression", run_fig12},
      {"fig13", "Fig. 13: error against iteration", run_fig13},
      {"fig14", "Fig. 14: iterations against number of particles", run_fig14},
      {"stop_test", "The stop test", run_stop_test},
  };
  return items;
}

State<2> run_paper_scene(
    const Scene<2>& scene, const PaperItem::Context& context,
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
