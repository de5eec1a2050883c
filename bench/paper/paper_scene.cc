#include "bench/paper/paper_scene.h"

#include <fmt/format.h>

#include <stdexcept>

#include "solvers/registry.h"
#include "solvers/step_solver.h"

namespace bipot {

State run_paper_scene(const Scene& scene, const PaperContext& context,
                      const std::function<void(const State&, const StepReport&)>& on_step) {
  const SolverEntry* entry = &require_solver(scene.solver.name);
  SolverOptions options = to_options(scene.solver);
  options.cancelled = context.interrupted;
  TimeStepper stepper(scene, make_step_solver(*entry, options), entry->needs_delassus);
  State state = initial_state(scene);
  for (int k = 0; k < scene.num_steps; ++k) {
    if (context.stopped()) break;
    const StepReport report = stepper.advance(state);
    if (!report.converged) {
      throw std::runtime_error(
          fmt::format("{}, step {}: {}", scene.title, report.step, report.message));
    }
    if (on_step) on_step(state, report);
  }
  return state;
}

}  // namespace bipot
