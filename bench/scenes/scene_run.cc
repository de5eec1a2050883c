#include "bench/scenes/scene_run.h"

#include <algorithm>

#include "bench/scenes/scene_stepper.h"

namespace bipot {
void SceneTotals::add(const StepReport& r) {
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

SceneRun run_scene(const Scene& scene, State& state, const SceneRunOptions& options) {
  SceneRun run;
  run.planned = options.steps.value_or(scene.num_steps);
  SceneStepper stepper(scene, options.solver, options.explicit_delassus, options.cancelled,
                       options.threads, options.on_failure);
  run.springs = stepper.springs();
  while (run.totals.steps < run.planned) {
    if (options.cancelled && options.cancelled()) {
      run.end = SceneRun::End::kCancelled;
      return run;
    }
    if (options.before_step) options.before_step(state);
    StepReport report;
    try {
      report = stepper.advance(state);
    } catch (const StepFailure& failure) {
      run.end = failure.kind == StepFailure::Kind::kCutShort ? SceneRun::End::kCancelled
                                                             : SceneRun::End::kFailed;
      run.failure = failure;
      run.failed_problem = stepper.problem();
      run.failed_start = stepper.start();
      return run;
    }
    run.totals.add(report);
    if (stepper.parts() > 1) ++run.totals.split;
    if (options.on_step && !options.on_step({state, report, stepper.problem(), stepper.start()})) {
      run.end = SceneRun::End::kStopped;
      return run;
    }
  }
  return run;
}

}  // namespace bipot
