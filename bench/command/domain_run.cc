#include "bench/command/domain_run.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <utility>

#include "core/stopwatch.h"

namespace bipot {
namespace {

/// The first process's files, and when they want the whole state.
template <int D>
class GatheredOutput {
 public:
  /// Keeps references. `state`: the whole.
  GatheredOutput(const SceneIn<D>& scene, const StateIn<D>& state, const RunFolderOptions& folder,
                 ProcessGroup& group)
      : scene_(scene), group_(group), writes_(!folder.folder.empty()) {
    if (writes_ && group.rank() == 0) files_.emplace(scene, state, folder);
  }

  /// Of the state after a step. `wanted`: also for somebody else; then it is handed on.
  StateIn<D> step(const DomainStateIn<D>& state, const StepReportIn<D>& report, bool wanted) {
    const Stopwatch watch;
    StateIn<D> whole;
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
  StateIn<D> gather(const DomainStateIn<D>& state) {
    const Traffic before = group_.traffic();
    StateIn<D> whole = gather_state(state, group_);
    gathering_.add_since(before, group_.traffic());
    ++gathers_;
    return whole;
  }
  void finish(const StateIn<D>& whole, SceneRunIn<D>& run, DomainCounts& counts) {
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

  const SceneIn<D>& scene_;
  ProcessGroup& group_;
  bool writes_;
  std::optional<RunFolderIn<D>> files_;
  const ContactProblem none_;
  const Vector no_start_;
  double seconds_ = 0;
  int gathers_ = 0;
  Traffic gathering_;
};

Json to_json(const Traffic& traffic, int steps) {
  const double n = std::max(steps, 1);
  return {{"messages", static_cast<double>(traffic.messages) / n},
          {"bytes", static_cast<double>(traffic.bytes) / n},
          {"reductions", static_cast<double>(traffic.reductions) / n},
          {"reduced_bytes", static_cast<double>(traffic.reduced_bytes) / n}};
}

}  // namespace

template <int D>
std::string state_on_every_process(const RunFlags& flags, const SceneIn<D>& scene) {
  if (flags.reproducible) return "--reproducible";
  if (!flags.dump_problems.empty()) return "--dump-problems";
  if (flags.on_failure != RunFlags{}.on_failure) return "--on-failure " + flags.on_failure;
  return needs_whole_state(scene);
}

template <int D>
SceneRunIn<D> run_domains(const SceneIn<D>& scene, StateIn<D>& state,
                          const DomainRunOptionsIn<D>& options, ProcessGroup& group,
                          DomainCounts& counts) {
  using End = typename SceneRunIn<D>::End;
  SceneRunIn<D> run;
  run.planned = options.steps;
  GatheredOutput<D> output(scene, state, options.folder, group);
  DomainStepperIn<D> stepper(scene, group, options.solver);
  DomainStateIn<D> domain = stepper.begin(state);
  state = {};
  while (run.totals.steps < run.planned) {
    if (options.cancelled && options.cancelled()) {
      run.end = End::kCancelled;
      break;
    }
    DomainReportIn<D> step;
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
    const StateIn<D> whole = output.step(domain, step.report, tell);
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

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

Json to_json(const DomainCounts& c, double peak_bytes) {
  return {{"most_bodies", c.most_bodies},
          {"most_ghosts", c.most_ghosts},
          {"most_contacts", c.most_contacts},
          {"most_halo", c.most_halo},
          {"imbalance", c.imbalance},
          {"cuts", c.cuts},
          {"migrated", c.migrated},
          {"gathers", c.gathers},
          {"peak_bytes", peak_bytes},
          {"a_step",
           {{"detection", to_json(c.detection, c.steps)},
            {"solve", to_json(c.solve, c.steps)},
            {"migration", to_json(c.migration, c.steps)},
            {"gathering", to_json(c.gathering, c.steps)}}}};
}

std::string to_text(const DomainCounts& c) {
  const double n = std::max(c.steps, 1);
  const auto sent = [&](const Traffic& t) {
    return fmt::format("{:.1f} messages, {:.3g} kB", static_cast<double>(t.messages) / n,
                       1e-3 * static_cast<double>(t.bytes) / n);
  };
  return fmt::format(
      "  one has      at most {} bodies and {} ghosts, {} contacts and {} of others; imbalance "
      "{:.2f}\n"
      "  moved        {} bodies to other processes, cells cut again {} times\n"
      "  one sends    a step: detection {}; solve {};\n"
      "               migration {}; {} gathered states {}\n",
      c.most_bodies, c.most_ghosts, c.most_contacts, c.most_halo, c.imbalance, c.migrated, c.cuts,
      sent(c.detection), sent(c.solve), sent(c.migration), c.gathers, sent(c.gathering));
}

template std::string state_on_every_process(const RunFlags&, const Scene&);
template std::string state_on_every_process(const RunFlags&, const SceneIn<3>&);
template SceneRunIn<2> run_domains(const Scene&, State&, const DomainRunOptionsIn<2>&,
                                   ProcessGroup&, DomainCounts&);
template SceneRunIn<3> run_domains(const SceneIn<3>&, StateIn<3>&, const DomainRunOptionsIn<3>&,
                                   ProcessGroup&, DomainCounts&);

}  // namespace bipot
