#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "bench/measure/limited_solve.h"
#include "bench/tradeoff/adviser.h"
#include "solvers/registry.h"

namespace bipot {

template <int D>
void Adviser<D>::measure_spread() {
  Scene<D> other = scene_;
  other.solver.warm_start = !other.solver.warm_start;
  const Samples samples =
      stretches(other, sample_, exact(factor_, accuracy_), TimeBudget::kTrialsEnd);
  if (!samples.empty()) {
    advice_.spread = added_errors(samples, chosen_runs(), floor_, first_).bound();
  }
}

template <int D>
Advice::SolverTrial Adviser<D>::try_solver(const SolverVariant& variant, double tol,
                                           const Samples& reference, double cpu_limit) const {
  Advice::SolverTrial trial{
      .solver = variant, .tol = tol, .stretches = static_cast<int>(sample_.size())};
  const RunSetting setting = setting_of(variant, tol);
  Samples samples;
  double cpu = 0;
  int solves = 0, steps = 0;
  for (const State<D>* start : sample_) {
    RunLimits limits = until(TimeBudget::kLastTrialEnd, tol);
    limits.cpu_seconds = cpu_limit - cpu;
    samples.push_back(run_stretch(scene_, *start, steps_, setting, limits));
    const RunRecord& run = samples.back().run;
    cpu += run.cpu;
    solves += run.solves;
    steps += run.steps;
    trial.seconds += run.solve_cpu;
    trial.iterations += run.iterations * run.steps;
    trial.guarded = std::fmax(trial.guarded, run.worst_guarded);
    if (!run.whole) {
      trial.message = fmt::format("{}: {}", run.status, run.message);
      if (cpu > cpu_limit) trial.message = fmt::format("more than {:.2g} s of CPU", cpu_limit);
      break;
    }
    ++trial.solved;
  }
  trial.seconds /= std::max(1, solves);
  trial.iterations /= std::max(1, steps);
  if (trial.solved == trial.stretches) {
    trial.error = added_errors(samples, reference, floor_, first_);
  }
  return trial;
}

template <int D>
void Adviser<D>::try_solvers() {
  std::vector<SolverVariant> variants = options_.solvers;
  if (variants.empty()) {
    variants = promising_solvers(advice_.sample.contacts_max, scene_.has_friction() ? D : 1);
  }
  for (SolverVariant& variant : variants) {
    warm_up(require_solver(variant.solver));
    // A run by the scene's own solver has the scene's parameters, its plan among them.
    if (variant.solver != scene_.solver.name) continue;
    variant.parameters.insert(scene_.solver.parameters.begin(), scene_.solver.parameters.end());
  }
  Samples reference = chosen_runs();
  double reference_tol = tight_, best = kInfinity;  // CPU seconds of all stretches
  int solves = 0;
  for (const StretchSample& sample : reference) solves += sample.run.solves;
  for (const SolverVariant& variant : variants) {
    say("trying " + variant.label);
    int met = 0;
    for (int k = 1; k <= 12 && met < 2; ++k) {
      if (options_.stopped()) return;
      if (time_.past(TimeBudget::kTrialsEnd)) {
        advice_.out_of_time = true;
        return;
      }
      const double tol = std::pow(10.0, -k);
      // A trial no looser than the reference cannot be judged by it.
      constexpr double kTighter = 0.1;
      if (reference_tol > 1.01 * kTighter * tol) {
        RunSetting tighter = exact(factor_, accuracy_);
        tighter.tol = kTighter * tol;
        Samples more = stretches(scene_, sample_, tighter, TimeBudget::kLastTrialEnd);
        if (more.empty()) break;
        reference = std::move(more);
        reference_tol = tighter.tol;
      }
      // A solver that takes four times as long as the best so far is left.
      Advice::SolverTrial trial = try_solver(variant, tol, reference, std::max(0.25, 4 * best));
      const bool solved = trial.solved == trial.stretches;
      if (meets(trial, advice_.budget, advice_.spread)) {
        ++met;
        trial.verdict = Advice::SolverTrial::Verdict::kMet;
        best = std::min(best, trial.seconds * solves);
      }
      advice_.trials.push_back(std::move(trial));
      if (!solved) break;
    }
  }
}

template <int D>
void Adviser<D>::choose_solver() {
  measure_spread();
  try_solvers();
  mark_pareto(advice_.trials, advice_.goal);
  // The cheapest of those that meet the budget, else the nearest.
  const std::vector<int> order = by_cost(advice_.trials, advice_.budget, advice_.spread);
  advice_.choice = order.empty() ? nearest_trial(advice_.trials, advice_.budget) : order.front();
  if (order.empty()) return;
  advice_.trials[to_size(order.front())].verdict = Advice::SolverTrial::Verdict::kChosen;
}

template void Adviser<2>::choose_solver();
template void Adviser<3>::choose_solver();

}  // namespace bipot
