#include "bench/tune/greedy_schedule.h"

#include <algorithm>

namespace bipot {
namespace {

// Budgets tried of one variant: quantiles of the works of the instances that it solves.
constexpr std::size_t kQuantiles = 12;

std::vector<double> budgets_of(std::span<const TunedInstance* const> left, std::size_t variant,
                               double done) {
  std::vector<double> works;
  for (const TunedInstance* instance : left) {
    const TunedInstance::Outcome& outcome = instance->outcomes[variant];
    if (outcome.solved && outcome.work > done) works.push_back(outcome.work);
  }
  std::ranges::sort(works);
  if (works.size() <= kQuantiles) return works;
  std::vector<double> budgets;
  for (std::size_t k = 1; k <= kQuantiles; ++k) {
    budgets.push_back(works[(works.size() * k) / kQuantiles - 1]);
  }
  return budgets;
}

}  // namespace

double TunedInstance::Outcome::seconds_of(double budget) const {
  if (work <= 0) return 0;  // cannot run: left out
  return seconds * std::min(1.0, budget / work);
}

std::vector<ScheduledStage> greedy_schedule(std::span<const TunedInstance* const> instances) {
  constexpr std::size_t kMostStages = 6;
  std::vector<ScheduledStage> schedule;
  std::vector<const TunedInstance*> left;
  for (const TunedInstance* instance : instances) {
    if (instance->best > 0) left.push_back(instance);
  }
  if (left.empty()) return schedule;
  std::vector<double> done(left.front()->outcomes.size(), 0);
  while (!left.empty() && schedule.size() < kMostStages) {
    ScheduledStage best;
    double best_rate = 0;
    for (std::size_t v = 0; v < done.size(); ++v) {
      for (const double budget : budgets_of(left, v, done[v])) {
        double solved = 0, cost = 0;
        for (const TunedInstance* instance : left) {
          const TunedInstance::Outcome& outcome = instance->outcomes[v];
          solved += outcome.solved && outcome.work <= budget;
          cost += (outcome.seconds_of(budget) - outcome.seconds_of(done[v])) / instance->best;
        }
        if (solved / cost > best_rate) {
          best_rate = solved / cost;
          best = {v, budget};
        }
      }
    }
    if (best_rate == 0) break;
    if (!schedule.empty() && schedule.back().variant == best.variant) schedule.pop_back();
    schedule.push_back(best);
    done[best.variant] = best.budget;
    std::erase_if(left, [&](const TunedInstance* instance) {
      const TunedInstance::Outcome& outcome = instance->outcomes[best.variant];
      return outcome.solved && outcome.work <= best.budget;
    });
  }
  return schedule;
}

double seconds_of(std::span<const ScheduledStage> schedule, const TunedInstance& instance,
                  bool* solved) {
  std::vector<double> done(instance.outcomes.size(), 0);
  double seconds = 0;
  for (const auto& [variant, budget] : schedule) {
    const TunedInstance::Outcome& outcome = instance.outcomes[variant];
    seconds += outcome.seconds_of(budget) - outcome.seconds_of(done[variant]);
    done[variant] = budget;
    if (outcome.solved && outcome.work <= budget && seconds <= instance.limit) {
      if (solved != nullptr) *solved = true;
      return seconds;
    }
  }
  if (solved != nullptr) *solved = false;
  return instance.limit;
}

}  // namespace bipot
