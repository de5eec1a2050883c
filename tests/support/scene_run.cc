#include "tests/support/scene_run.h"

#include <gtest/gtest.h>

#include "solvers/registry.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {

template <int D>
State<D> run_scene(
    const Scene<D>& scene,
    const std::type_identity_t<std::function<void(const State<D>&, const StepReport<D>&)>>& on_step,
    const std::string& solver) {
  const SolverEntry* entry = find_solver(solver.empty() ? scene.solver.name : solver);
  EXPECT_NE(entry, nullptr);
  SolverOptions options;
  options.tol = scene.solver.tol;
  options.max_iterations = scene.solver.max_iterations;
  if (solver.empty()) options.parameters = scene.solver.parameters;
  TimeStepper<D> stepper(scene, make_step_solver(*entry, options), entry->needs_delassus);
  State<D> state = initial_state(scene);
  for (int step = 0; step < scene.num_steps; ++step) {
    const StepReport<D> report = stepper.advance(state);
    EXPECT_TRUE(report.converged) << "step " << report.step << ": " << report.message;
    if (on_step) on_step(state, report);
  }
  return state;
}

template State<2> run_scene<2>(const Scene<2>&,
                               const std::function<void(const State<2>&, const StepReport<2>&)>&,
                               const std::string&);
template State<3> run_scene<3>(const Scene<3>&,
                               const std::function<void(const State<3>&, const StepReport<3>&)>&,
                               const std::string&);

}  // namespace bipot
