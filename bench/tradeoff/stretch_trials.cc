#include "bench/tradeoff/stretch_trials.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bench/measure/stopwatch.h"
#include "bench/tradeoff/solver_trials.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

/// The windows solved to a tolerance; empty if a step fails.
std::vector<WindowRun> solve_windows(const StretchReference& reference, bool warm, double tol,
                                     const AdviseOptions& options, const TimeBudget& time) {
  SolverOptions tight;
  tight.tol = tol;
  tight.cancelled = options.interrupted;
  const StepSolver solver =
      limited_solver(require_solver("auto"), tight, [&] { return time.until(1); });
  const int steps = static_cast<int>(std::lround(reference.window / reference.scene.step));
  Scene<2> scene = reference.scene;
  scene.solver.warm_start = warm;
  std::vector<WindowRun> runs;
  for (const State<2>* start : reference.starts) {
    runs.push_back(run_window(scene, *start, reference.factor, steps, solver, 10 * tol));
    if (!runs.back().usable) return {};
  }
  return runs;
}

/// Solves the windows again, more tightly. False, and no change, if a step fails.
bool tighten(StretchReference& reference, double tol, const AdviseOptions& options,
             const TimeBudget& time) {
  std::vector<WindowRun> runs =
      solve_windows(reference, reference.scene.solver.warm_start, tol, options, time);
  if (runs.empty()) return false;
  reference.runs = std::move(runs);
  reference.tol = tol;
  return true;
}

/// Errors that runs add to a reference with the same step.
Accuracy added_errors(const std::vector<WindowRun>& runs, const StretchReference& reference) {
  const double radius = smallest_radius(reference.scene);
  Accuracy error = window_errors(runs, reference.runs, radius, reference.floor);
  error.penetration = 0;  // added by the solver to that of the step
  for (std::size_t w = 0; w < runs.size(); ++w) {
    const double more = (runs[w].penetration - reference.runs[w].penetration) / radius;
    error.penetration = std::max(error.penetration, more);
  }
  return error;
}

/// Runs a trial over the windows of the study, against tight solves with the same step. Errors of a
/// step are then the start of the next, which trials of single steps cannot show.
void run_stretches(SolverTrial& trial, StretchReference& reference, const AdviseOptions& options,
                   const TimeBudget& time) {
  trial.stretch = {kInfinity, kInfinity, kInfinity};
  // A trial no looser than the reference cannot be judged by it.
  constexpr double kTighter = 0.1;
  if (reference.tol > 1.01 * kTighter * trial.tol &&
      !tighten(reference, kTighter * trial.tol, options, time)) {
    trial.message = "no reference for stretches that is tighter";
    return;
  }
  const int steps = static_cast<int>(std::lround(reference.window / reference.scene.step));
  Scene<2> scene = reference.scene;
  scene.solver.warm_start = trial.warm;
  SolverOptions own;
  own.tol = trial.tol;
  own.parameters = trial.solver.parameters;
  own.cancelled = options.interrupted;
  int solves = 0;
  double seconds = 0;
  const StepSolver limited =
      limited_solver(require_solver(trial.solver.solver), own, [&] { return time.until(1); });
  const StepSolver solver = [&](const ContactProblem& p, const Vector& s0) {
    const CpuStopwatch watch;
    StepSolution solution = limited(p, s0);
    if (p.num_contacts() > 0) {
      seconds += watch.seconds();
      ++solves;
    }
    return solution;
  };
  std::vector<WindowRun> runs;
  for (const State<2>* start : reference.starts) {
    runs.push_back(run_window(scene, *start, reference.factor, steps, solver, trial.tol));
    if (runs.back().usable) continue;
    trial.message = "a step of a stretch was not solved";
    return;
  }
  trial.stretches = static_cast<int>(runs.size());
  if (solves > 0) trial.run_seconds = seconds / solves;
  trial.stretch = added_errors(runs, reference);
}

}  // namespace

void measure_spread(StretchReference& reference, const AdviseOptions& options,
                    const TimeBudget& time) {
  const std::vector<WindowRun> runs =
      solve_windows(reference, !reference.scene.solver.warm_start, reference.tol, options, time);
  if (!runs.empty()) reference.spread = added_errors(runs, reference);
}

void try_stretches(StretchReference reference, const std::vector<SampledProblem>& problems,
                   const AdviseOptions& options, const TimeBudget& time, Advice& advice) {
  using Verdict = SolverTrial::Verdict;
  const auto same_line = [](const SolverTrial& a, const SolverTrial& b) {
    return a.solver.label == b.solver.label && a.warm == b.warm;
  };
  double best = kInfinity;  // seconds of a solve of trials that met the budget on stretches
  while (!options.stopped()) {
    if (time.past(best < kInfinity ? TimeBudget::kStretchesEnd : 1)) return;
    int next = -1;
    for (int i : by_cost(advice.trials, advice.budget)) {
      const SolverTrial& trial = advice.trials[i];
      // Tried; or missed already at a tighter tolerance, or met at a looser one for less.
      const bool settled =
          std::any_of(advice.trials.begin(), advice.trials.end(), [&](const SolverTrial& t) {
            return same_line(t, trial) &&
                   ((t.tol <= trial.tol && t.verdict == Verdict::kStretchMissed) ||
                    (t.tol >= trial.tol && t.verdict == Verdict::kStretchMet));
          });
      if (settled) continue;
      next = i;
      break;
    }
    if (next < 0 || advice.trials[next].seconds > 3 * best) return;
    SolverTrial& trial = advice.trials[next];
    run_stretches(trial, reference, options, time);
    if (share_of(without_lost_digits(trial.stretch, reference.spread), advice.budget) <= 1) {
      trial.verdict = Verdict::kStretchMet;
      best = std::min(best, trial.run_seconds);
      continue;
    }
    trial.verdict = Verdict::kStretchMissed;
    const SolverTrial missed = trial;  // adding to the trials moves them
    const double tol = 0.1 * missed.tol;
    const bool known = std::any_of(
        advice.trials.begin(), advice.trials.end(),
        [&](const SolverTrial& t) { return same_line(t, missed) && t.tol < 1.01 * tol; });
    if (known || tol < 1e-12) continue;
    const TrialPair pair = try_solver(missed.solver, tol, problems, time.until(1), options);
    advice.trials.push_back(missed.warm ? pair.warm : pair.cold);
  }
}

}  // namespace bipot
