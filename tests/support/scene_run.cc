#include "tests/support/scene_run.h"

#include <gtest/gtest.h>

#include "solvers/registry.h"
#include "solvers/step_solver.h"

namespace bipot {

template <int D>
StateIn<D> run_scene(
    const SceneIn<D>& scene,
    const std::type_identity_t<std::function<void(const StateIn<D>&, const StepReportIn<D>&)>>&
        on_step,
    const std::string& solver) {
  const SolverEntry* entry = find_solver(solver.empty() ? scene.solver.name : solver);
  EXPECT_NE(entry, nullptr);
  SolverOptions options;
  options.tol = scene.solver.tol;
  options.max_iterations = scene.solver.max_iterations;
  if (solver.empty()) options.parameters = scene.solver.parameters;
  TimeStepperIn<D> stepper(scene, make_step_solver(*entry, options), entry->needs_delassus);
  StateIn<D> state = initial_state(scene);
  for (int step = 0; step < scene.num_steps; ++step) {
    const StepReportIn<D> report = stepper.advance(state);
    EXPECT_TRUE(report.converged) << "step " << report.step << ": " << report.message;
    if (on_step) on_step(state, report);
  }
  return state;
}

template State run_scene<2>(const Scene&,
                            const std::function<void(const State&, const StepReport&)>&,
                            const std::string&);
template StateIn<3> run_scene<3>(
    const SceneIn<3>&, const std::function<void(const StateIn<3>&, const StepReportIn<3>&)>&,
    const std::string&);

}  // namespace bipot
