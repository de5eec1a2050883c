#include "tests/support/scene_run.h"

#include <gtest/gtest.h>

#include "solvers/registry.h"
#include "solvers/step_solver.h"

namespace bipot {

State run_scene(const Scene& scene,
                const std::function<void(const State&, const StepReport&)>& on_step,
                const std::string& solver) {
  const SolverEntry* entry = find_solver(solver.empty() ? scene.solver.name : solver);
  EXPECT_NE(entry, nullptr);
  SolverOptions options;
  options.tol = scene.solver.tol;
  options.max_iterations = scene.solver.max_iterations;
  if (solver.empty()) options.parameters = scene.solver.parameters;
  TimeStepper stepper(scene, make_step_solver(*entry, options), entry->needs_delassus);
  State state = initial_state(scene);
  for (int step = 0; step < scene.num_steps; ++step) {
    const StepReport report = stepper.advance(state);
    EXPECT_TRUE(report.converged) << "step " << report.step << ": " << report.message;
    if (on_step) on_step(state, report);
  }
  return state;
}

}  // namespace bipot
