#include "solvers/simulation/scene_run.h"

#include <algorithm>

#include "solvers/simulation/scene_stepper.h"

namespace bipot {

template <int D>
void SceneTotals<D>::add(const StepReport<D>& r) {
  ++steps;
  converged += r.converged ? 1 : 0;
  if (!r.converged && first_unconverged < 0) {
    first_unconverged = r.step;
    message = r.message;
  }
  contacts += r.contacts;
  iterations += r.iterations;
  max_contacts = std::max(max_contacts, r.contacts);
  max_iterations = std::max(max_iterations, r.iterations);
  penetration = std::max(penetration, r.penetration);
  if (worst_step < 0 || !(r.error.guarded() <= worst.guarded())) {
    worst = r.error;
    worst_step = r.step;
  }
  detection_seconds += r.detection_seconds;
  assembly_seconds += r.assembly_seconds;
  solve_seconds += r.solve_seconds;
  last = r;
}

template <int D>
SceneRun<D> run_scene(const Scene<D>& scene, State<D>& state,
                      const std::type_identity_t<SceneRunOptions<D>>& options) {
  using End = typename SceneRun<D>::End;
  SceneRun<D> run;
  run.planned = options.steps.value_or(scene.num_steps);
  SceneStepper<D> stepper(scene, options.solver, options.explicit_delassus, options.cancelled,
                          options.threads, options.on_failure);
  run.springs = stepper.springs();
  while (run.totals.steps < run.planned) {
    if (options.cancelled && options.cancelled()) {
      run.end = End::kCancelled;
      return run;
    }
    if (options.before_step) options.before_step(state);
    StepReport<D> report;
    try {
      report = stepper.advance(state);
    } catch (const StepFailure& failure) {
      run.end = failure.kind == StepFailure::Kind::kCutShort ? End::kCancelled : End::kFailed;
      run.failure = failure;
      run.failed_problem = stepper.problem();
      run.failed_start = stepper.start();
      return run;
    }
    run.totals.add(report);
    if (stepper.parts() > 1) ++run.totals.split;
    if (options.on_step && !options.on_step({state, report, stepper.problem(), stepper.start()})) {
      run.end = End::kStopped;
      return run;
    }
  }
  return run;
}

template struct SceneTotals<2>;
template struct SceneTotals<3>;
template SceneRun<2> run_scene(const Scene<2>&, State<2>&, const SceneRunOptions<2>&);
template SceneRun<3> run_scene(const Scene<3>&, State<3>&, const SceneRunOptions<3>&);

}  // namespace bipot
