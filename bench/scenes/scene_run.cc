#include "bench/scenes/scene_run.h"

#include <algorithm>
#include <utility>

#include "solvers/registry.h"
#include "solvers/step_solver.h"

namespace bipot {
namespace {

/// Either model behind one advance().
class SceneStepper {
 public:
  SceneStepper(const Scene& scene, const SceneRunOptions& options) {
    if (!options.solver && scene.model == Model::kSpringDashpot) {
      springs_.emplace(scene, options.cancelled);
      return;
    }
    StepSolver solver = options.solver;
    bool explicit_delassus = options.explicit_delassus;
    if (!solver) {
      const SolverEntry& entry = require_solver(scene.solver.name);
      SolverOptions choice = to_options(scene.solver);
      choice.cancelled = options.cancelled;
      choice.execution.threads = options.threads;
      solver = make_step_solver(entry, std::move(choice));
      explicit_delassus = entry.needs_delassus;
    }
    rigid_.emplace(
        scene,
        [this, solver = std::move(solver)](const ContactProblem& problem, const Vector& start) {
          start_ = start;
          return solver(problem, start);
        },
        explicit_delassus, options.threads);
  }
  SceneStepper(const SceneStepper&) = delete;  // the solver knows where start_ is
  SceneStepper& operator=(const SceneStepper&) = delete;

  StepReport advance(State& state) {
    return springs_ ? springs_->advance(state) : rigid_->advance(state);
  }
  const ContactProblem& problem() const { return rigid_ ? rigid_->problem() : none_; }
  const Vector& start() const { return start_; }
  std::optional<SpringDashpotSetup> springs() const {
    if (!springs_) return std::nullopt;
    return springs_->setup();
  }

 private:
  std::optional<SpringDashpotStepper> springs_;
  std::optional<TimeStepper> rigid_;
  Vector start_;
  ContactProblem none_;
};

}  // namespace

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
  SceneStepper stepper(scene, options);
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
    if (options.on_step && !options.on_step({state, report, stepper.problem(), stepper.start()})) {
      run.end = SceneRun::End::kStopped;
      return run;
    }
  }
  return run;
}

}  // namespace bipot
