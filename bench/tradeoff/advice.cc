#include "bench/tradeoff/advice.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/types.h"

namespace bipot {
namespace {

// Fractions of a goal that the time step may use: comfortably, and at most.
constexpr double kComfortable = 0.5, kMost = 0.9;

bool solved_everywhere(const SolverTrial& trial) {
  return trial.problems > 0 && trial.solved == trial.problems;
}

/// Times in one class differ by less than the noise of a busy machine.
int time_class(double seconds) {
  constexpr double kShort = 2e-5;
  return seconds < kShort ? 0 : 1 + static_cast<int>(std::log(seconds / kShort) / std::log(1.2));
}

}  // namespace

std::string_view name_of(double Accuracy::*measure) {
  if (measure == &Accuracy::force) return "force error";
  return measure == &Accuracy::penetration ? "penetration" : "energy error";
}

Accuracy worst_of(const Accuracy& a, const Accuracy& b) {
  Accuracy worst;
  for (auto m : Accuracy::kMeasures) worst.*m = std::fmax(a.*m, b.*m);
  return worst;
}

double share_of(const Accuracy& error, const Accuracy& goal) {
  double share = 0;
  for (auto m : Accuracy::kMeasures) {
    if (!std::isnan(goal.*m) && !std::isnan(error.*m)) share = std::max(share, error.*m / goal.*m);
  }
  return share;
}

StepChoice choose_step(const std::vector<StepTrial>& steps, const Accuracy& goal) {
  // A larger step is not better than a smaller one: such a measurement is chance.
  const auto share = [&](const StepTrial& trial) {
    double largest = 0;
    for (const StepTrial& other : steps) {
      if (other.step <= trial.step) largest = std::max(largest, share_of(other.error, goal));
    }
    return largest;
  };
  const auto largest_within = [&](double part) {
    int best = -1;
    for (int i = 0; i < static_cast<int>(steps.size()); ++i) {
      if (share(steps[i]) > part) continue;
      if (best < 0 || steps[i].step > steps[best].step) best = i;
    }
    return best;
  };
  if (const int i = largest_within(kComfortable); i >= 0) return {i, true};
  if (const int i = largest_within(kMost); i >= 0) return {i, true};
  // Errors of neighbouring steps differ by chance: of those near the smallest, the largest step.
  constexpr double kNear = 1.25;
  double smallest = std::numeric_limits<double>::infinity();
  for (const StepTrial& trial : steps) smallest = std::min(smallest, share(trial));
  return {largest_within(kNear * smallest), false};
}

Accuracy solver_budget(const Accuracy& goal, const Accuracy& step_error) {
  Accuracy budget;
  for (auto m : Accuracy::kMeasures) {
    const double taken = std::isnan(step_error.*m) ? 0 : step_error.*m;
    budget.*m = taken <= kMost * goal.*m ? goal.*m - taken : 0.5 * taken;
    if (std::isnan(goal.*m)) budget.*m = kNaN;
  }
  return budget;
}

Accuracy without_lost_digits(const Accuracy& error, const Accuracy& spread) {
  Accuracy counted = error;
  for (auto m : Accuracy::kMeasures) {
    if (error.*m <= 0.5 * spread.*m) counted.*m = 0;
  }
  return counted;
}

bool meets(const SolverTrial& trial, const Accuracy& budget) {
  return solved_everywhere(trial) && share_of(trial.error, budget) <= 1;
}

std::vector<int> by_cost(const std::vector<SolverTrial>& trials, const Accuracy& budget) {
  std::vector<int> order;
  for (int i = 0; i < static_cast<int>(trials.size()); ++i) {
    if (meets(trials[i], budget)) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return time_class(trials[a].seconds) < time_class(trials[b].seconds);
  });
  return order;
}

int nearest_trial(const std::vector<SolverTrial>& trials, const Accuracy& budget) {
  const bool stretches = std::any_of(trials.begin(), trials.end(),
                                     [](const SolverTrial& t) { return t.stretches > 0; });
  int nearest = -1;
  double smallest = 0;
  for (int i = 0; i < static_cast<int>(trials.size()); ++i) {
    const SolverTrial& trial = trials[i];
    if (!solved_everywhere(trial) || (stretches && trial.stretches == 0)) continue;
    const double share = share_of(worst_of(trial.error, trial.stretch), budget);
    if (nearest >= 0 && share >= smallest) continue;
    nearest = i;
    smallest = share;
  }
  return nearest;
}

void mark_pareto(std::vector<SolverTrial>& trials, const Accuracy& goal) {
  const bool stretches = std::any_of(trials.begin(), trials.end(),
                                     [](const SolverTrial& t) { return t.stretches > 0; });
  const auto counts = [&](const SolverTrial& t) {
    return solved_everywhere(t) && (!stretches || t.stretches > 0);
  };
  const auto seconds = [&](const SolverTrial& t) { return stretches ? t.run_seconds : t.seconds; };
  const auto share = [&](const SolverTrial& t) {
    return share_of(worst_of(t.error, t.stretch), goal);
  };
  for (SolverTrial& a : trials) {
    a.pareto = counts(a) && std::none_of(trials.begin(), trials.end(), [&](const SolverTrial& b) {
                 return counts(b) && seconds(b) <= seconds(a) && share(b) <= share(a) &&
                        (seconds(b) < seconds(a) || share(b) < share(a));
               });
  }
}

double smallest_goal(const Accuracy& goal) {
  double smallest = kInfinity;
  for (auto m : Accuracy::kMeasures) smallest = std::fmin(smallest, goal.*m);
  return smallest;
}

double tight_tolerance(const Accuracy& goal) {
  return std::clamp(1e-3 * smallest_goal(goal), 1e-9, 1e-3);
}

double loose_tolerance(const Accuracy& goal) {
  return std::clamp(0.1 * smallest_goal(goal), 1e-9, 1e-2);
}

std::string_view to_string(Advice::Status status) {
  switch (status) {
    case Advice::Status::kMet:
      return "met";
    case Advice::Status::kNotMet:
      return "not met";
    case Advice::Status::kNoContacts:
      return "no contacts";
    case Advice::Status::kInterrupted:
      return "interrupted";
  }
  return "not met";
}

}  // namespace bipot
