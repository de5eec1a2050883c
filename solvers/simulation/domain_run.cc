#include "solvers/simulation/domain_run.h"

#include <optional>

#include "core/base/stopwatch.h"

namespace bipot {
namespace {

/// The first process's files, and when they want the whole state.
template <int D>
class GatheredOutput {
 public:
  /// Keeps references. `state`: the whole.
  GatheredOutput(const Scene<D>& scene, const State<D>& state, const RunFolderOptions& folder,
                 ProcessGroup& group)
      : scene_(scene), group_(group), writes_(!folder.folder.empty()) {
    if (writes_ && group.rank() == 0) files_.emplace(scene, state, folder);
  }

  /// Of the state after a step. `wanted`: also for somebody else; then it is handed on.
  State<D> step(const DomainState<D>& state, const StepReport<D>& report, bool wanted) {
    const Stopwatch watch;
    State<D> whole;
    if (is_due(report.step) || wanted) {
      whole = gather(state);
    } else {
      whole.step = report.step;
      whole.time = report.time;
    }
    if (files_) files_->step({whole, report, none_, no_start_});
    seconds_ += watch.seconds();
    return whole;
  }
  State<D> gather(const DomainState<D>& state) {
    const Traffic before = group_.traffic();
    State<D> whole = gather_state(state, group_);
    gathering_.add_since(before, group_.traffic());
    ++gathers_;
    return whole;
  }
  void finish(const State<D>& whole, SceneRun<D>& run, DomainCounts& counts) {
    const Stopwatch watch;
    if (files_) files_->finish(whole, run);
    run.output_seconds = seconds_ + watch.seconds();
    counts.gathers = gathers_;
    counts.gathering = gathering_;
  }

 private:
  bool is_due(int step) const {
    if (!writes_) return false;
    const OutputChoice& output = scene_.output;
    const auto every = [&](int steps) { return steps > 0 && step % steps == 0; };
    return every(output.every) || every(output.ledger_every) || !output.track.empty();
  }

  const Scene<D>& scene_;
  ProcessGroup& group_;
  bool writes_;
  std::optional<RunFolder<D>> files_;
  const ContactProblem none_;
  const Vector no_start_;
  double seconds_ = 0;
  int gathers_ = 0;
  Traffic gathering_;
};

}  // namespace

template <int D>
SceneRun<D> run_domains(const Scene<D>& scene, State<D>& state, const DomainRunOptions<D>& options,
                        ProcessGroup& group, DomainCounts& counts) {
  using End = typename SceneRun<D>::End;
  SceneRun<D> run;
  run.planned = options.steps;
  GatheredOutput<D> output(scene, state, options.folder, group);
  DomainStepper<D> stepper(scene, group, options.solver);
  DomainState<D> domain = stepper.begin(state);
  state = {};
  while (run.totals.steps < run.planned) {
    if (options.cancelled && options.cancelled()) {
      run.end = End::kCancelled;
      break;
    }
    DomainReport<D> step;
    try {
      step = stepper.advance(domain);
    } catch (const StepFailure& failure) {
      run.end = failure.kind == StepFailure::Kind::kCutShort ? End::kCancelled : End::kFailed;
      run.failure = failure;
      run.failed_problem = stepper.gather_last_problem();
      break;
    }
    const bool first_unsolved = !step.report.converged && run.totals.first_unconverged < 0;
    run.totals.add(step.report);
    const bool tell = first_unsolved && options.on_unsolved != nullptr;
    const State<D> whole = output.step(domain, step.report, tell);
    if (tell) {
      const ContactProblem problem = stepper.gather_last_problem();
      if (group.rank() == 0) options.on_unsolved({whole, step.report, problem, Vector()});
    }
    if (options.on_step) options.on_step(step);
  }
  state = output.gather(domain);
  counts = stepper.counts();
  output.finish(state, run, counts);
  counts = largest_counts(counts, group);
  return run;
}

template SceneRun<2> run_domains(const Scene<2>&, State<2>&, const DomainRunOptions<2>&,
                                 ProcessGroup&, DomainCounts&);
template SceneRun<3> run_domains(const Scene<3>&, State<3>&, const DomainRunOptions<3>&,
                                 ProcessGroup&, DomainCounts&);

}  // namespace bipot
