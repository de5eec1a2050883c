#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "solvers/auto/plan.h"

namespace bipot {

struct TunedInstance {
  /// What one variant did on one instance (a problem, a start, a tolerance).
  struct Outcome {
    double work = 0;     ///< iterations in the variant's unit, until solved or given up; 0: not run
    double seconds = 0;  ///< until then
    bool solved = false;

    /// Time of the first `budget` units of work; infinite beyond what was run.
    double seconds_of(double budget) const;
  };
  ProblemTraits traits;           ///< what a plan knows of it
  std::vector<Outcome> outcomes;  ///< one for each variant
  double limit = 0;               ///< time that a schedule may take                       [s]
  double best = 0;                ///< least time of a variant that solves it; its unit of time  [s]
};

/// Run the variant until its work in all stages is `budget`.
struct ScheduledStage {
  std::size_t variant = 0;
  double budget = 0;
};

/// The schedule of least expected time to solve, by greedy choice (Streeter and Golovin 2008): each
/// stage is the one that solves most of the instances that are left for the time spent on them, in
/// units of their best times. Budgets are among the works of solved instances. The greedy schedule
/// takes at most four times the time of the best one where a stage costs the same on all instances.
/// It ends where no stage solves another instance, or after six.
std::vector<ScheduledStage> greedy_schedule(std::span<const TunedInstance* const> instances);

/// Time of the schedule on the instance, at most its limit, which is that of one it does not solve.
double seconds_of(std::span<const ScheduledStage> schedule, const TunedInstance& instance,
                  bool* solved = nullptr);

}  // namespace bipot
