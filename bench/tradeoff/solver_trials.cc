#include "bench/tradeoff/solver_trials.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "bench/measure/stopwatch.h"
#include "bench/measure/warm_up.h"
#include "solvers/registry.h"
#include "solvers/solve.h"

namespace bipot {
namespace {

/// A solve from s0 (size 0: cold).
struct TimedSolve {
  SolveResult result;
  double seconds = 0;  // CPU, least of a few repeats if it is short
};
TimedSolve timed_solve(const SolverVariant& variant, const ContactProblem& p, double tol,
                       double limit, const Vector& s0, const AdviseOptions& options) {
  SolverOptions solver;
  solver.tol = tol;
  solver.time_limit = limit;
  solver.parameters = variant.parameters;
  solver.s0 = s0;
  solver.cancelled = options.interrupted;
  constexpr double kLong = 2e-3;
  TimedSolve timed;
  timed.seconds = kInfinity;
  for (int k = 0; k < 3; ++k) {
    const CpuStopwatch watch;
    timed.result = solve(variant.solver, p, solver);
    timed.seconds = std::min(timed.seconds, watch.seconds());
    if (timed.seconds > kLong) break;
  }
  return timed;
}

void add(SolverTrial& trial, const SampledProblem& sample, const TimedSolve& timed) {
  ++trial.problems;
  trial.seconds += timed.seconds;
  trial.iterations += timed.result.iterations;
  if (!is_success(timed.result.status)) {
    if (trial.message.empty()) {
      trial.message = fmt::format("{}: {}", to_string(timed.result.status), timed.result.message);
    }
    return;
  }
  ++trial.solved;
  trial.guarded = std::fmax(trial.guarded, timed.result.error.guarded());
  const TrueError error = (*sample.true_error)(timed.result.s);
  // Errors below that of the reference are unknown.
  const double unknown = sample.reference.error.guarded();
  trial.error = worst_of(trial.error, without_lost_digits({error.force + unknown, error.penetration,
                                                           error.energy + unknown},
                                                          sample.spread));
}

}  // namespace

std::vector<SolverVariant> promising_solvers(int contacts) {
  constexpr int kPivoting = 60;      // beyond it, pivoting is never the fastest
  constexpr int kSplitting = 20000;  // beyond it, its factors take too long to set up
  std::vector<SolverVariant> variants;
  const auto add_if = [&](bool wanted, SolverVariant variant) {
    if (wanted && find_solver(variant.solver) != nullptr) variants.push_back(std::move(variant));
  };
  add_if(true, {"auto", "auto", {}});
  add_if(true, {"apgd", "apgd", {}});
  add_if(true, {"assor", "assor", {}});
  add_if(true, {"ipm", "ipm", {}});
  add_if(true, {"newton", "newton", {}});
  add_if(true, {"pgs", "pgs", {}});
  add_if(true, {"pgs omega=1.5", "pgs", {{"omega", "1.5"}}});
  add_if(contacts <= kSplitting, {"admm", "admm", {}});
  add_if(contacts <= kPivoting, {"lemke", "lemke", {}});
  return variants;
}

TrialPair try_solver(const SolverVariant& variant, double tol,
                     const std::vector<SampledProblem>& problems, double limit,
                     const AdviseOptions& options) {
  TrialPair pair;
  for (SolverTrial* trial : {&pair.cold, &pair.warm}) {
    trial->solver = variant;
    trial->tol = tol;
  }
  pair.warm.warm = true;
  for (const SampledProblem& sample : problems) {
    const ContactProblem& p = sample.given.problem;
    const TimedSolve cold = timed_solve(variant, p, tol, limit, Vector(), options);
    add(pair.cold, sample, cold);
    if (!is_success(cold.result.status)) break;
    if (!sample.has_before) {
      add(pair.warm, sample, cold);  // nothing to start from
      continue;
    }
    const TimedSolve before = timed_solve(variant, sample.before, tol, limit, Vector(), options);
    const Vector s0 = before.result.s.size() == sample.before.num_rows()
                          ? carry_over(sample, before.result.s)
                          : Vector();
    add(pair.warm, sample, timed_solve(variant, p, tol, limit, s0, options));
  }
  for (SolverTrial* trial : {&pair.cold, &pair.warm}) {
    if (trial->problems == 0) continue;
    trial->seconds /= trial->problems;
    trial->iterations /= trial->problems;
    // Ended early: not all problems were tried.
    trial->problems = static_cast<int>(problems.size());
  }
  return pair;
}

void try_solvers(const std::vector<SampledProblem>& problems, const AdviseOptions& options,
                 const TimeBudget& time, Advice& advice) {
  const std::vector<SolverVariant> variants =
      options.solvers.empty() ? promising_solvers(advice.sample.contacts_max) : options.solvers;
  for (const SolverVariant& variant : variants) {
    warm_up(require_solver(variant.solver));
  }
  double best = kInfinity;  // seconds of a solve that meets all
  for (const SolverVariant& variant : variants) {
    if (options.say) options.say(fmt::format("trying {}", variant.label));
    int met = 0;
    for (int k = 1; k <= 12 && met < 2; ++k) {
      if (options.stopped()) return;
      if (time.past(TimeBudget::kTrialsEnd)) return;
      // A solver that takes twenty times as long as the best so far is rejected.
      const double limit = std::min(time.until(TimeBudget::kTrialsEnd), std::max(0.25, 20 * best));
      const TrialPair pair = try_solver(variant, std::pow(10.0, -k), problems, limit, options);
      const bool has_warm = std::any_of(problems.begin(), problems.end(),
                                        [](const SampledProblem& s) { return s.has_before; });
      advice.trials.push_back(pair.cold);
      if (has_warm && pair.cold.solved == pair.cold.problems) advice.trials.push_back(pair.warm);
      bool any = false;
      for (const SolverTrial* trial : {&pair.cold, &pair.warm}) {
        if (!meets(*trial, advice.budget)) continue;
        any = true;
        best = std::min(best, trial->seconds);
      }
      // One tolerance beyond the first that meets the budget: a reserve for the fresh steps.
      if (meets(pair.cold, advice.budget) || (any && met > 0)) ++met;
      if (pair.cold.solved < pair.cold.problems) break;
    }
  }
}

}  // namespace bipot
