#include "bench/tradeoff/sampled_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <utility>

#include "bench/tradeoff/window_run.h"
#include "solvers/registry.h"
#include "solvers/simulation/scene_run.h"

namespace bipot {
namespace {

constexpr std::size_t kMaxCheckpoints = 64;

}  // namespace

SampledRun sampled_run(const Scene<2>& scene, double tol, double part, const AdviseOptions& options,
                       const TimeBudget& time) {
  SampledRun run;
  run.seen.steps_planned = scene.num_steps;
  SolverOptions solver;
  solver.tol = tol;
  solver.cancelled = options.interrupted;
  State<2> state = initial_state(scene), before;
  int stride = 1;
  double overhead = 0;
  // States at every quarter of a window. A window from the third last of them has the present in
  // its middle, where its weight is large.
  const int quarter = window_length(scene, options.window).steps / 4;
  std::deque<State<2>> leads;
  SceneRunOptions<2> to_sample;
  to_sample.solver =
      limited_solver(require_solver("auto"), solver, [&] { return time.until(part); });
  to_sample.before_step = [&](State<2>& next) {
    before = next;
    if (run.seen.steps_run % quarter == 0) {
      leads.push_back(next);
      if (leads.size() > 3) leads.pop_front();
    }
  };
  to_sample.on_step = [&](const SceneStep<2>& step) {
    const StepReport<2>& report = step.report;
    ++run.seen.steps_run;
    overhead += report.detection_seconds + report.assembly_seconds;
    run.seen.contacts_max = std::max(run.seen.contacts_max, report.contacts);
    if (report.contacts > 0) {
      if (run.seen.contact_steps % stride == 0) run.checkpoints.push_back({before, leads.front()});
      ++run.seen.contact_steps;
      if (run.checkpoints.size() > kMaxCheckpoints) {
        for (std::size_t i = 1; 2 * i < run.checkpoints.size(); ++i) {
          run.checkpoints[i] = std::move(run.checkpoints[2 * i]);
        }
        run.checkpoints.resize((run.checkpoints.size() + 1) / 2);
        stride *= 2;
      }
    }
    return run.seen.steps_run == scene.num_steps || !time.past(part);
  };
  const SceneRun<2> taken = run_scene(scene, state, to_sample);
  if (taken.end == SceneRun<2>::End::kFailed) {
    run.seen.note = fmt::format("the run ended: {}", taken.failure->what());
  } else if (taken.end != SceneRun<2>::End::kCompleted) {
    run.seen.note = fmt::format("time for the run was up after {} steps", run.seen.steps_run);
  }
  if (run.seen.steps_run > 0) run.seen.overhead_seconds = overhead / run.seen.steps_run;
  return run;
}

Selection select_steps(std::size_t available, int samples, int fresh) {
  Selection selection;
  const std::size_t wanted = std::min<std::size_t>(available, samples + fresh);
  for (std::size_t i = 0; i < wanted; ++i) {
    const std::size_t at = wanted == 1 ? 0 : i * (available - 1) / (wanted - 1);
    // The second of each group is fresh; the first and the last step stay in the sample.
    const int all = samples + fresh, next = static_cast<int>(i) + 2;
    const bool take = i + 1 < wanted && next * fresh / all > (next - 1) * fresh / all;
    (take ? selection.fresh : selection.sample).push_back(at);
  }
  return selection;
}

}  // namespace bipot
