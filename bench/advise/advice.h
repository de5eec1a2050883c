#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/measure/solver_variant.h"
#include "core/types.h"

namespace bipot {

/// Errors in the terms in which a user asks for accuracy. As a goal: NaN is not asked for. As a
/// measurement: NaN is not measured, or nothing is there to be wrong.
struct Accuracy {
  double force = kNaN;        ///< of the resultant on a body, over the largest one            [-]
  double penetration = kNaN;  ///< overlap that a step adds, over the smallest radius          [-]
  double energy = kNaN;       ///< of the dissipated energy, relative                          [-]

  static constexpr double Accuracy::*kMeasures[] = {&Accuracy::force, &Accuracy::penetration,
                                                    &Accuracy::energy};
};
std::string_view name_of(double Accuracy::*measure);
/// Componentwise larger, NaN only where both are.
Accuracy worst_of(const Accuracy& a, const Accuracy& b);
/// Largest error / goal over what is asked for and measured; 0 when there is nothing.
double share_of(const Accuracy& error, const Accuracy& goal);

/// What a time step makes wrong when its problems are solved exactly.
struct StepTrial {
  double factor = 1;  ///< of the scene's step
  double step = 0;    ///< h                                                                [s]
  Accuracy error;
};

struct StepChoice {
  int index = -1;
  bool met = false;  ///< the step leaves at least a tenth of every goal to the solver
};
/// A step counts with the worst error of itself and all smaller ones. The largest step that takes
/// at most half of every goal; else the largest that takes at most nine tenths; else, not met, the
/// largest whose share is within a quarter of the smallest share. Steps in any order; empty: index
/// -1.
StepChoice choose_step(const std::vector<StepTrial>& steps, const Accuracy& goal);

/// What is left to the solver: goal - step's error. Where the step misses the goal, half of the
/// step's error: digits below it are thrown away by the step.
Accuracy solver_budget(const Accuracy& goal, const Accuracy& step_error);

/// One solver at one tolerance over all sampled problems.
struct SolverTrial {
  SolverVariant solver;
  double tol = 0;
  bool warm = false;  ///< from the impulses that it found itself in the step before
  int problems = 0, solved = 0;
  Accuracy error;         ///< worst over the problems
  double guarded = 0;     ///< worst
  double seconds = 0;     ///< CPU of one solve, mean over the problems
  double iterations = 0;  ///< mean
  bool pareto = false;    ///< see mark_pareto
  /// Over stretches of the run, each step with the errors of the steps before; NaN: not tried.
  Accuracy stretch;
  int stretches = 0;       ///< behind `stretch`
  double run_seconds = 0;  ///< CPU of one solve there, mean
  enum class Verdict { kNone, kStretchMissed, kStretchMet, kFreshMissed, kChosen };
  Verdict verdict = Verdict::kNone;
  std::string message;  ///< why it was not solved everywhere
};
/// Solved everywhere, and no asked-for error above the budget.
bool meets(const SolverTrial& trial, const Accuracy& budget);
/// Those that meet the budget, cheapest first. Times in one class (below 20 µs; above, a fifth
/// wide) count as equal and stay in the order given.
std::vector<int> by_cost(const std::vector<SolverTrial>& trials, const Accuracy& budget);
/// Index of the trial that was solved everywhere with the smallest share of the budget, -1: none.
/// Of those run on stretches, where any was.
int nearest_trial(const std::vector<SolverTrial>& trials, const Accuracy& budget);
/// Marks the trials, solved everywhere, that no other one beats in both time and share of the goal:
/// on stretches where any trial was run on them (the others are then not marked), else on steps.
void mark_pareto(std::vector<SolverTrial>& trials, const Accuracy& goal);

}  // namespace bipot
