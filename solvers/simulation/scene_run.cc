#include "solvers/simulation/scene_run.h"

#include <algorithm>
#include <stdexcept>

#include "core/base/stopwatch.h"
#include "solvers/simulation/run_folder.h"
#include "solvers/simulation/scene_stepper.h"

namespace bipot {

template <int D>
void SceneTotals<D>::add_parts(const StepReport<D>& r) {
  if (cut.parts == 0 || r.cut.smallest < cut.smallest) {
    cut.smallest = r.cut.smallest;
    cut.limited_by = r.cut.limited_by;
    cut_step = r.step;
  }
  if (r.cut.misplaced > cut.misplaced) {
    cut.misplaced = r.cut.misplaced;
    misplaced_step = r.step;
  }
  cut.misplaced_sum += r.cut.misplaced_sum;
  cut.parts += r.cut.parts;
  cut.misplacing += r.cut.misplacing;
  cut.drifting += r.cut.drifting;
  cut.accelerating += r.cut.accelerating;
  cut.failed += r.cut.failed;
}

template <int D>
void SceneTotals<D>::add(const StepReport<D>& r) {
  ++steps;
  converged += r.converged ? 1 : 0;
  if (!r.converged && first_unconverged < 0) first_unconverged = r.step;
  if (!r.converged && (worst_unconverged < 0 || !(r.error.guarded() <= unconverged.guarded()))) {
    worst_unconverged = r.step;
    unconverged = r.error;
    message = r.message;
  }
  contacts += r.contacts;
  iterations += r.iterations;
  max_contacts = std::max(max_contacts, r.contacts);
  max_iterations = std::max(max_iterations, r.iterations);
  unsolvable += r.unsolvable ? 1 : 0;
  penetration = std::max(penetration, r.penetration);
  if (r.overlap > overlap) {
    overlap = r.overlap;
    overlap_step = r.step;
    overlap_pair = r.overlap_pair;
  }
  deep_overlaps += r.overlap > kDeepOverlap ? 1 : 0;
  if (r.travel > travel) {
    travel = r.travel;
    travel_step = r.step;
  }
  if (r.cut.parts > 0) add_parts(r);
  passages += r.passages;
  if (r.passages > 0 && passage_step < 0) {
    passage_step = r.step;
    passage = r.passage;
  }
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
  if (options.processes == nullptr) {  // others may have given up their bodies
    if (auto defect = validate(scene); !defect.empty()) throw std::invalid_argument(defect);
    if (auto other = count_mismatch(scene, state); !other.empty()) {
      throw std::invalid_argument("the state does not fit the scene: " + other);
    }
  }
  SceneRun<D> run;
  run.planned = options.steps.value_or(scene.num_steps);
  SceneStepper<D> stepper(scene, options);
  run.springs = stepper.springs();
  const bool writes = !options.folder.folder.empty();
  std::optional<RunFolder<D>> files;
  if (writes && (options.processes == nullptr || options.processes->rank() == 0)) {
    files.emplace(scene, state, options.folder);
  }
  State<D>& here = stepper.begin(state);
  Domain<D>* const domain = stepper.domain();
  while (run.totals.steps < run.planned) {
    if (stepper.is_over()) {
      run.end = End::kCancelled;
      break;
    }
    if (options.before_step) options.before_step(here);
    stepper.name_overlaps_beyond(run.totals.overlap);
    StepReport<D> report;
    try {
      report = stepper.advance(here);
    } catch (const StepFailure& failure) {
      run.end = failure.kind == StepFailure::Kind::kCutShort ? End::kCancelled : End::kFailed;
      run.failure = failure;
      const bool assembled =
          failure.kind != StepFailure::Kind::kPassage && failure.kind != StepFailure::Kind::kPlaces;
      if (assembled) {  // else no solver can help
        run.failed_problem = domain != nullptr ? domain->gather_problem() : stepper.problem();
        run.failed_start = stepper.start();
      }
      break;
    }
    const bool first_unsolved = !report.converged && run.totals.first_unconverged < 0;
    run.totals.add(report);
    if (stepper.parts() > 1) ++run.totals.split;

    Stopwatch output;
    ContactProblem problem;
    if (domain != nullptr) {
      state.step = report.step;
      state.time = report.time;
      if (first_unsolved) problem = domain->gather_problem();
      if (first_unsolved || (writes && needs_state(scene.output, report.step))) {
        state = domain->gather();
      }
    }
    const SceneStep<D> step{state, report, domain != nullptr ? problem : stepper.problem(),
                            stepper.start(), stepper.parts() > 1 || report.cut.parts > 1};
    if (files) files->step(step);
    run.output_seconds += output.seconds();
    const bool go_on = !options.on_step || options.on_step(step);
    if (domain != nullptr) state = {};
    if (!go_on) {
      run.end = End::kStopped;
      break;
    }
  }
  Stopwatch output;
  if (domain != nullptr) {
    state = domain->gather();
    run.domains =
        std::make_shared<DomainCounts>(largest_counts(domain->counts(), *options.processes));
  }
  if (files) files->finish(state, run);
  if (files || domain != nullptr) run.output_seconds += output.seconds();
  return run;
}

template struct SceneTotals<2>;
template struct SceneTotals<3>;
template SceneRun<2> run_scene(const Scene<2>&, State<2>&, const SceneRunOptions<2>&);
template SceneRun<3> run_scene(const Scene<3>&, State<3>&, const SceneRunOptions<3>&);

}  // namespace bipot
