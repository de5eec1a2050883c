#include "bench/tradeoff/advice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "bench/report/labels.h"
#include "solvers/registry.h"

namespace bipot {
namespace {

// Fractions of a goal that the time step may use: comfortably, and at most.
constexpr double kComfortable = 0.5, kMost = 0.9;

bool solved_everywhere(const Advice::SolverTrial& trial) {
  return trial.stretches > 0 && trial.solved == trial.stretches;
}

/// Times in one class differ by less than the noise of a busy machine.
int time_class(double seconds) {
  constexpr double kShort = 2e-5;
  return seconds < kShort ? 0 : 1 + static_cast<int>(std::log(seconds / kShort) / std::log(1.2));
}

}  // namespace

const Accuracy::Measure Accuracy::kMeasures[6] = {
    {&Accuracy::force, "force", "force"},
    {&Accuracy::penetration, "penetration", "penetration"},
    {&Accuracy::energy, "energy", "energy"},
    {&Accuracy::load, "load", "wall load"},
    {&Accuracy::coordination, "coordination", "coordination"},
    {&Accuracy::stress_ratio, "stress_ratio", "τ/P"}};

Accuracy MeasuredError::bound() const {
  Accuracy sum = error;
  for (const auto& [m, key, name] : Accuracy::kMeasures) {
    if (std::isfinite(bar.*m)) sum.*m += bar.*m;
  }
  return sum;
}

Accuracy MeasuredError::least() const {
  Accuracy least = error;
  for (const auto& [m, key, name] : Accuracy::kMeasures) {
    if (!std::isnan(error.*m)) least.*m = std::max(0.0, error.*m - std::fmax(bar.*m, 0));
  }
  return least;
}

bool bars_known(const MeasuredError& measured, const Accuracy& goal) {
  return std::ranges::none_of(Accuracy::kMeasures, [&](const auto& q) {
    return !std::isnan(goal.*q.value) && std::isinf(measured.bar.*q.value);
  });
}

double share_of(const Accuracy& error, const Accuracy& goal) {
  double share = 0;
  for (const auto& [m, key, name] : Accuracy::kMeasures) {
    if (!std::isnan(goal.*m) && !std::isnan(error.*m)) share = std::max(share, error.*m / goal.*m);
  }
  return share;
}

std::string with_bar(double error, double bar) {
  if (std::isnan(error)) return "not measured";
  if (std::isnan(bar)) return compact_label(error);
  return fmt::format("{} ± {}", compact_label(error),
                     std::isinf(bar) ? "unknown" : compact_label(bar));
}

std::string error_against(const MeasuredError& measured, const Accuracy& goal) {
  std::string text;
  for (const auto& [m, key, name] : Accuracy::kMeasures) {
    if (std::isnan(goal.*m)) continue;
    text += fmt::format("{}{} {} of {}", text.empty() ? "" : ", ", name,
                        with_bar(measured.error.*m, measured.bar.*m), compact_label(goal.*m));
  }
  return text;
}

namespace {

/// The choice among equal steps.
Advice::StepChoice choose_equal_step(const std::vector<Advice::StepTrial>& steps,
                                     const Accuracy& goal) {
  // A larger step is not better than a smaller one: such a measurement is chance.
  const auto share = [&](const Advice::StepTrial& trial) {
    double largest = share_of(trial.error.bound(), goal);
    for (const Advice::StepTrial& other : steps) {
      if (other.accuracy == 0 && other.step < trial.step) {
        largest = std::max(largest, share_of(other.error.least(), goal));
      }
    }
    return largest;
  };
  const auto largest_within = [&](double part) {
    int best = -1;
    for (int i = 0; i < static_cast<int>(steps.size()); ++i) {
      if (steps[i].accuracy > 0 || share(steps[i]) > part) continue;
      if (best < 0 || steps[i].step > steps[best].step) best = i;
    }
    return best;
  };
  if (const int i = largest_within(kComfortable); i >= 0) return {i, true};
  if (const int i = largest_within(kMost); i >= 0) return {i, true};
  // Bounds of neighbouring steps differ by chance: of those near the smallest, the largest step.
  // Steps that surely miss come after all others.
  constexpr double kNear = 1.25;
  std::vector<bool> left;
  for (const Advice::StepTrial& trial : steps) {
    left.push_back(trial.accuracy == 0 && share_of(trial.error.least(), goal) <= kMost);
  }
  if (std::ranges::find(left, true) == left.end()) {
    for (std::size_t i = 0; i < steps.size(); ++i) left[i] = steps[i].accuracy == 0;
  }
  double smallest = kInfinity;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (left[i]) smallest = std::min(smallest, share(steps[i]));
  }
  int best = -1;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (!left[i] || share(steps[i]) > kNear * smallest) continue;
    if (best < 0 || steps[i].step > steps[to_size(best)].step) best = static_cast<int>(i);
  }
  return {best, false};
}

}  // namespace

Advice::StepChoice choose_step(const std::vector<Advice::StepTrial>& steps, const Accuracy& goal) {
  Advice::StepChoice choice = choose_equal_step(steps, goal);
  const auto share = [&](int i) { return share_of(steps[to_size(i)].error.bound(), goal); };
  for (int i = 0; i < static_cast<int>(steps.size()); ++i) {
    if (steps[to_size(i)].accuracy == 0) continue;
    const bool met = share(i) <= kMost;
    const bool better = choice.index < 0 || (choice.met ? steps[to_size(i)].seconds <
                                                              steps[to_size(choice.index)].seconds
                                                        : met || share(i) < share(choice.index));
    if (better && (met || !choice.met)) choice = {i, met};
  }
  choice.met = choice.met && bars_known(steps[to_size(choice.index)].error, goal);
  return choice;
}

Accuracy solver_budget(const Accuracy& goal, const Accuracy& step_bound) {
  Accuracy budget;
  for (const auto& [m, key, name] : Accuracy::kMeasures) {
    const double taken = std::isnan(step_bound.*m) ? 0 : step_bound.*m;
    budget.*m = taken <= kMost * goal.*m ? goal.*m - taken : 0.5 * taken;
    if (std::isnan(goal.*m)) budget.*m = kNaN;
  }
  return budget;
}

Accuracy without_lost_digits(const Accuracy& error, const Accuracy& spread) {
  Accuracy counted = error;
  for (const auto& [m, key, name] : Accuracy::kMeasures) {
    if (error.*m <= spread.*m) counted.*m = 0;
  }
  return counted;
}

bool meets(const Advice::SolverTrial& trial, const Accuracy& budget, const Accuracy& spread) {
  return solved_everywhere(trial) &&
         share_of(without_lost_digits(trial.error.bound(), spread), budget) <= 1;
}

std::vector<int> by_cost(const std::vector<Advice::SolverTrial>& trials, const Accuracy& budget,
                         const Accuracy& spread) {
  std::vector<int> order;
  for (int i = 0; i < static_cast<int>(trials.size()); ++i) {
    if (meets(trials[i], budget, spread)) order.push_back(i);
  }
  std::ranges::stable_sort(order, {}, [&](int k) { return time_class(trials[k].seconds); });
  return order;
}

int nearest_trial(const std::vector<Advice::SolverTrial>& trials, const Accuracy& budget) {
  int nearest = -1;
  for (int i = 0; i < static_cast<int>(trials.size()); ++i) {
    if (!solved_everywhere(trials[i])) continue;
    const auto share = [&](int k) { return share_of(trials[k].error.bound(), budget); };
    if (nearest < 0 || share(i) < share(nearest)) nearest = i;
  }
  return nearest;
}

void mark_pareto(std::vector<Advice::SolverTrial>& trials, const Accuracy& goal) {
  for (Advice::SolverTrial& a : trials) {
    const double share = share_of(a.error.error, goal);
    a.pareto =
        solved_everywhere(a) && std::ranges::none_of(trials, [&](const Advice::SolverTrial& b) {
          const double other = share_of(b.error.error, goal);
          return solved_everywhere(b) && b.seconds <= a.seconds && other <= share &&
                 (b.seconds < a.seconds || other < share);
        });
  }
}

double smallest_goal(const Accuracy& goal) {
  double smallest = kInfinity;
  for (const auto& [m, key, name] : Accuracy::kMeasures) smallest = std::fmin(smallest, goal.*m);
  return smallest;
}

double tight_tolerance(const Accuracy& goal) {
  return std::clamp(1e-3 * smallest_goal(goal), 1e-9, 1e-3);
}

double loose_tolerance(const Accuracy& goal) {
  return std::clamp(0.1 * smallest_goal(goal), 1e-9, 1e-2);
}

std::vector<SolverVariant> promising_solvers(int contacts, int dim) {
  constexpr int kPivoting = 60;      // beyond it, pivoting is never the fastest
  constexpr int kSplitting = 20000;  // beyond it, its factors take too long to set up
  std::vector<SolverVariant> variants;
  const auto add_if = [&](bool wanted, SolverVariant variant) {
    const SolverEntry* entry = find_solver(variant.solver);
    if (wanted && entry != nullptr && dim <= entry->max_dim) variants.push_back(std::move(variant));
  };
  add_if(true, {"auto", "auto", {}});
  add_if(true, {"apgd", "apgd", {}});
  add_if(true, {"assor", "assor", {}});
  add_if(true, {"pgs", "pgs", {}});
  add_if(true, {"pgs omega=1.5", "pgs", {{"omega", "1.5"}}});
  add_if(true, {"ipm", "ipm", {}});
  add_if(true, {"newton", "newton", {}});
  add_if(contacts <= kSplitting, {"admm", "admm", {}});
  add_if(contacts <= kPivoting, {"lemke", "lemke", {}});
  return variants;
}

std::string_view to_string(Advice::Status status) {
  constexpr std::string_view kNames[] = {"met", "not met", "undecided", "no contacts",
                                         "interrupted"};
  return kNames[static_cast<int>(status)];
}

MeasuredError expected_error(const Advice& a) {
  MeasuredError sum = a.step_error;
  if (a.choice < 0) return sum;
  const MeasuredError& solver = a.trials[to_size(a.choice)].error;
  const auto add = [](double& x, double y) {
    if (!std::isnan(y)) x = std::isnan(x) ? y : x + y;
  };
  for (const auto& [m, key, name] : Accuracy::kMeasures) {
    add(sum.error.*m, solver.error.*m);
    add(sum.bar.*m, solver.bar.*m);
  }
  double& overlap = sum.error.penetration;
  if (a.run.steps > 0) overlap = a.run.whole() ? a.run.overlap : std::fmax(overlap, a.run.overlap);
  return sum;
}

}  // namespace bipot
