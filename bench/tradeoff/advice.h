#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "bench/measure/solver_variant.h"
#include "core/base/types.h"

namespace bipot {

/// Errors in the quantities of a user's goal. As a goal: NaN is no requirement. As a measurement:
/// NaN is not measured, or undefined.
struct Accuracy {
  double force = kNaN;        ///< of the resultant on a body, over the largest one            [-]
  double penetration = kNaN;  ///< overlap that a step adds, over the smallest radius          [-]
  double energy = kNaN;       ///< of the dissipated energy, relative                          [-]

  static constexpr double Accuracy::*kMeasures[] = {&Accuracy::force, &Accuracy::penetration,
                                                    &Accuracy::energy};
};
std::string_view name_of(double Accuracy::*measure);
/// Componentwise larger, NaN only if both are.
Accuracy worst_of(const Accuracy& a, const Accuracy& b);
/// Largest ratio of error to goal over the required and measured quantities; 0 if there are none.
double share_of(const Accuracy& error, const Accuracy& goal);

/// Error of a time step whose problems are solved exactly.
struct StepTrial {
  double factor = 1;  ///< of the scene's step
  double step = 0;    ///< h                                                                [s]
  Accuracy error;
};

struct StepChoice {
  int index = -1;
  bool met = false;  ///< the step leaves at least a tenth of every goal to the solver
};
/// A step counts with the worst error of itself and all smaller ones. The choice is the largest
/// step that takes at most half of every goal; else the largest that takes at most nine tenths.
/// Else the goal is not met, and it is the largest whose share is within a quarter of the smallest
/// share. Steps in any order; empty: index -1.
StepChoice choose_step(const std::vector<StepTrial>& steps, const Accuracy& goal);

/// Error allowed for the solver: goal - step's error. If the step misses the goal, half of the
/// step's error: further digits are lost in the step.
Accuracy solver_budget(const Accuracy& goal, const Accuracy& step_error);

/// Errors that count on a step with several exact answers. Those up to half of the difference of
/// the answers are 0, since no answer is preferred. NaN in `spread`: all count.
Accuracy without_lost_digits(const Accuracy& error, const Accuracy& spread);

/// One solver at one tolerance over all sampled problems.
struct SolverTrial {
  SolverVariant solver;
  double tol = 0;
  bool warm = false;  ///< from its own impulses of the previous step
  int problems = 0, solved = 0;
  Accuracy error;         ///< worst over the problems, see without_lost_digits
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
/// Solved everywhere, and no required error above the budget.
bool meets(const SolverTrial& trial, const Accuracy& budget);
/// Those that meet the budget, cheapest first. Times in one class (below 20 µs; above, a fifth
/// wide) count as equal and stay in the order given.
std::vector<int> by_cost(const std::vector<SolverTrial>& trials, const Accuracy& budget);
/// Index of the trial solved everywhere with the smallest share of the budget, -1: none. If any
/// trial was run on stretches, only those count.
int nearest_trial(const std::vector<SolverTrial>& trials, const Accuracy& budget);
/// Marks the trials, solved everywhere, that no other one beats in both time and share of the goal.
/// If any trial was run on stretches, only those are compared, by their errors there; else all, by
/// those on steps.
void mark_pareto(std::vector<SolverTrial>& trials, const Accuracy& goal);

/// The smallest required number; infinite without one.
double smallest_goal(const Accuracy& goal);
/// Tolerance whose own error is negligible beside the goal, for everything but the trials. A looser
/// one sometimes opens contacts at rest by more than the contact distance.
double tight_tolerance(const Accuracy& goal);
/// Tolerance of the sampled run, if a tight one takes too long. Its errors move the samples, but do
/// not enter errors. If it is too loose, contacts at rest come and go.
double loose_tolerance(const Accuracy& goal);

struct AdviseOptions {
  Accuracy goal;                       ///< at least one entry, each > 0
  std::vector<SolverVariant> solvers;  ///< to try; empty: promising_solvers()
  double time_limit = 60;              ///< wall seconds of everything
  int samples = 6;                     ///< steps to choose on
  int fresh = 3;                       ///< further steps to verify on
  double window = 0;       ///< time over which forces are averaged [s]; 0: see StepStudy
  bool keep_step = false;  ///< only the scene's own time step
  std::function<void(const std::string& stage)> say;  ///< may be empty
  std::function<bool()> interrupted;                  ///< may be empty

  bool stopped() const { return interrupted && interrupted(); }
};

/// Properties of the scene from a run with `auto`.
struct SceneSample {
  int steps_planned = 0, steps_run = 0;
  int contact_steps = 0;  ///< of those run, with contacts
  int contacts_max = 0;
  double overhead_seconds = 0;  ///< of a step besides its solve: detection, assembly   [s]
  std::string note;             ///< why the run ended early; empty: it did not
};

/// Errors of time steps, over a window of time from sampled states. Steps of 4, 2, 1, ½, ¼ of the
/// scene's are compared with the finest that time allows (⅛), all solved tightly. Over the window,
///   force:       largest difference of a body's mean contact force over the largest such force on
///                a body; the worst window. Weights are hat-shaped, so that a shock that moves to
///                the next step counts by its time;
///   penetration: largest overlap that one step adds to a pair; the worst window. Exact: 0;
///   energy:      sum over the windows of the differences in dissipated energy, over the sum of
///                the energies.
/// Differences are scaled by r/(r - 1), r the ratio of the steps, as the reference has an error of
/// first order as well.
struct StepStudy {
  double window = 0;             ///< [s]: a fiftieth of the run, at least 16 of the scene's steps
  int windows = 0;               ///< that all entries of `steps` were measured on
  int windows_dropped = 0;       ///< a solve in them failed, or time ran out
  double finest = 0;             ///< factor of the reference
  std::vector<StepTrial> steps;  ///< from large to small
};

struct Advice {
  enum class Status { kMet, kNotMet, kNoContacts, kInterrupted };
  Status status = Status::kNotMet;
  /// One sentence: how the goal is met, or what fails and the best that is possible.
  std::string message;
  Accuracy goal;

  SceneSample sample;
  StepStudy steps;
  StepChoice step;       ///< index into steps.steps, -1: not studied, the scene's own is taken
  double step_size = 0;  ///< recommended                                             [s]
  int num_steps = 0;     ///< of the scene's simulated time with it
  Accuracy step_error;   ///< NaN where not studied

  Accuracy budget;  ///< left to the solver
  std::vector<SolverTrial> trials;
  int choice = -1;    ///< index into trials; -1: nothing to recommend
  SolverTrial fresh;  ///< the choice on steps that it was not chosen on; problems = 0: none
  int problems = 0, fresh_problems = 0;
  int several_solutions = 0;    ///< problems, chosen on and fresh, with several exact answers
  Accuracy spread;              ///< largest difference of two exact answers of one step
  Accuracy stretch_spread;      ///< of two tight runs of the same windows; NaN: not measured
  int without_reference = 0;    ///< problems left out: no reference clearly better than the goal
  double worst_reference = 0;   ///< guarded error
  double reference_spread = 0;  ///< largest relative difference of two solvers' references

  /// Whole windows from fresh states, the choice against the finest steps; NaN: not done.
  Accuracy whole_window;
  int whole_windows = 0;

  double seconds_per_step = 0;  ///< expected, everything but output
  double seconds_in_all = 0;
  double seconds_spent = 0;  ///< on the advice, wall
};
std::string_view to_string(Advice::Status status);

}  // namespace bipot
