#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "bench/measure/solver_variant.h"
#include "core/base/types.h"

namespace bipot {

/// Errors in the quantities of a user's goal, over stretches of a run. As a goal: NaN is no
/// requirement. As a measurement: NaN is not measured, or undefined. All relative           [-]
struct Accuracy {
  double force = kNaN;         ///< of a body's mean contact force, over the largest one, worst body
  double penetration = kNaN;   ///< largest overlap, over the smaller radius
  double energy = kNaN;        ///< of the mean dissipated energy
  double load = kNaN;          ///< of the mean force on a wall, over the largest one, worst wall
  double coordination = kNaN;  ///< of the mean number of loaded contacts of a body
  double stress_ratio = kNaN;  ///< of the mean τ/P

  struct Measure {
    double Accuracy::*value;
    const char *key, *name;
  };
  static const Measure kMeasures[6];
};
/// Largest ratio of error to goal over the required and measured quantities; 0 if there are none.
double share_of(const Accuracy& error, const Accuracy& goal);

/// A measured error with its bar: twice its standard error over the stretches, infinite for one.
/// Quantities that are largest values have no bar (NaN).
struct MeasuredError {
  Accuracy error, bar;

  Accuracy bound() const;  ///< error + bar; the error alone where the bar is infinite
  Accuracy least() const;  ///< error - bar, at least 0
};
/// No required quantity has an infinite bar.
bool bars_known(const MeasuredError& measured, const Accuracy& goal);

/// "3.6e-2 ± 1e-2", "3.6e-2 ± unknown"
std::string with_bar(double error, double bar);
/// Of the quantities with a goal: "energy 3.6e-2 ± 1e-2 of 5.0e-2, wall load not measured of 1e-2".
std::string error_against(const MeasuredError& measured, const Accuracy& goal);

struct Advice {
  /// Error of a time step whose problems are solved exactly.
  struct StepTrial {
    double factor = 1;  ///< of the scene's step
    double step = 0;    ///< h                                                                [s]
    MeasuredError error;
    double accuracy = 0;  ///< > 0: that cuts the step; 0: all steps are equal
    double seconds = 0;   ///< CPU of the stretches                                           [s]
  };
  struct StepChoice {
    int index = -1;
    /// The step leaves at least a tenth of every goal to the solver; its bars are known.
    bool met = false;
  };
  /// One solver at one tolerance over all stretches, each step from the errors of those before.
  struct SolverTrial {
    SolverVariant solver;
    double tol = 0;
    int stretches = 0, solved = 0;
    MeasuredError error;    ///< that it adds to the time step's
    double guarded = 0;     ///< worst
    double seconds = 0;     ///< CPU of one solve, mean
    double iterations = 0;  ///< mean of a step
    bool pareto = false;    ///< see mark_pareto
    enum class Verdict { kMissed, kMet, kChosen };
    Verdict verdict = Verdict::kMissed;
    std::string message;  ///< why it was not solved everywhere
  };
  /// Properties of the scene from a run with `auto`.
  struct Sample {
    int steps_planned = 0, steps_run = 0;
    int contact_steps = 0;  ///< of those run, with contacts
    int contacts_max = 0;
    int unsolved = 0;             ///< of those run
    int stretches = 0;            ///< to choose from
    double overhead_seconds = 0;  ///< CPU of a step besides its solve: detection, assembly   [s]
    double overlap = 0;           ///< largest, over the smaller radius
    std::string note;             ///< why the run ended early; empty: it did not
    bool failed = false;          ///< for another reason than time

    bool mostly_unsolved() const { return 2 * unsolved > contact_steps; }
  };
  /// The run as advised, from its start as far as time allowed.
  struct Run {
    int steps = 0, steps_planned = 0;
    int unsolved = 0;    ///< of the steps
    double cpu = 0;      ///< [s]
    double overlap = 0;  ///< largest, over the smaller radius
    int overlap_step = 0;
    std::string failure;  ///< why it ended before; empty: it did not

    bool whole() const { return steps > 0 && steps == steps_planned; }
  };
  /// Errors of time steps over stretches. Steps of 4, 2, 1, ½, ¼ of the scene's are compared with
  /// the finest that time allows (⅛, 1/16 for small overlaps), all solved tightly. Steps beyond the
  /// limit of the overlap are left out, and those that miss the scene's time by more than 1 %.
  /// Differences are scaled by r/(r - 1), r the ratio of the steps, as the reference has an error of
  /// first order as well. The overlap is the larger of that of the stretches and of that of the
  /// sampled run, in proportion to the step. Accuracies from a third of the allowed overlap on,
  /// which cut steps of a frame, are compared with the same reference.
  struct StepStudy {
    double window = 0;             ///< [s]: a fiftieth of the run, at least 16 of the scene's steps
    int windows = 0;               ///< stretches that all entries of `steps` were measured on
    int windows_dropped = 0;       ///< a solve in them failed, or time ran out
    double finest = 0;             ///< factor of the reference
    std::vector<StepTrial> steps;  ///< from large to small
  };
  struct Options {
    Accuracy goal;                       ///< entries > 0; none: default_goal of the scene
    std::vector<SolverVariant> solvers;  ///< to try; empty: promising_solvers()
    double time_limit = 60;              ///< wall seconds of everything
    int samples = 6;                     ///< stretches, besides the one with the deepest overlap
    double window = 0;                   ///< length of a stretch [s]; 0: see StepStudy
    bool keep_step = false;              ///< only the scene's own time step
    std::function<void(const std::string& stage)> say;  ///< may be empty
    std::function<bool()> interrupted;                  ///< may be empty

    bool stopped() const { return interrupted && interrupted(); }
  };
  static constexpr int kMostSamples = 64;
  static constexpr int kMoreSamples = 4;  ///< times as many halve the bars
  enum class Status { kMet, kNotMet, kUndecided, kNoContacts, kInterrupted };
  Status status = Status::kNotMet;
  /// One sentence: how the goal is met, or what fails and the best that is possible.
  std::string message;
  Accuracy goal;
  bool default_goal = false;  ///< the user gave none

  std::string scene, title;  ///< file; title
  double scene_step = 0;     ///< [s]
  double duration = 0;       ///< of the scene                                        [s]
  double cut = 0;            ///< accuracy for a goal of overlap; 0: none, or none is taken
  bool warm_start = true;    ///< of the scene, in all trials
  bool other_stop = false;   ///< of the scene, not the guarded one of the trials
  bool cohesion_without_range = false;  ///< of the scene: in impacts it grows with the time step

  Sample sample;
  StepStudy steps;
  StepChoice step;           ///< index into steps.steps, -1: not studied, the scene's own is taken
  double step_size = 0;      ///< recommended                                             [s]
  double accuracy = 0;       ///< recommended, that cuts the step; 0: equal steps
  int num_steps = 0;         ///< of the scene's simulated time with it
  MeasuredError step_error;  ///< NaN where not studied

  Accuracy budget;  ///< left to the solver
  std::vector<SolverTrial> trials;
  bool out_of_time = false;  ///< trials were left out
  int choice = -1;           ///< index into trials; -1: nothing to recommend
  /// Bound of the difference of two tight runs of the same stretches, started differently: several
  /// exact answers of a step, or chaos. No solver can promise less. NaN: not measured.
  Accuracy spread;
  Run run;

  double seconds_per_step = 0;  ///< expected CPU, everything but output
  double seconds_in_all = 0;
  double seconds_spent = 0;  ///< on the advice, wall
};

/// A step counts with its bound, and with the least error of all smaller ones. The choice is the
/// largest step that takes at most half of every goal; else the largest that takes at most nine
/// tenths. Else the goal is not met, and it is the largest whose share is within a quarter of the
/// smallest share. An accuracy that takes at most nine tenths is preferred where it is cheaper, or no
/// equal step does; so is one with a smaller share where none does. Any order; empty: index -1.
Advice::StepChoice choose_step(const std::vector<Advice::StepTrial>& steps, const Accuracy& goal);

/// Error allowed for the solver: goal - bound of the step. If the step misses the goal, half of the
/// bound: further digits are lost in the step.
Accuracy solver_budget(const Accuracy& goal, const Accuracy& step_bound);

/// Errors that count where two exact runs differ by `spread`. Those up to it are 0, since no answer
/// is preferred. NaN in `spread`: all count.
Accuracy without_lost_digits(const Accuracy& error, const Accuracy& spread);

/// Solved everywhere, and no required bound above the budget, lost digits aside.
bool meets(const Advice::SolverTrial& trial, const Accuracy& budget, const Accuracy& spread = {});
/// Those that meet the budget, cheapest first. Times in one class (below 20 µs; above, a fifth
/// wide) count as equal and stay in the order given.
std::vector<int> by_cost(const std::vector<Advice::SolverTrial>& trials, const Accuracy& budget,
                         const Accuracy& spread = {});
/// Index of the trial solved everywhere with the smallest share of the budget, -1: none.
int nearest_trial(const std::vector<Advice::SolverTrial>& trials, const Accuracy& budget);
/// Marks the trials, solved everywhere, that no other one beats in both time and share of the goal.
void mark_pareto(std::vector<Advice::SolverTrial>& trials, const Accuracy& goal);

/// The smallest required number; infinite without one.
double smallest_goal(const Accuracy& goal);
/// Tolerance whose own error is negligible beside the goal, for everything but the trials. A looser
/// one sometimes opens contacts at rest by more than the contact distance.
double tight_tolerance(const Accuracy& goal);
/// Tolerance of the sampled run, if a tight one takes too long. Its errors move the samples, but do
/// not enter errors. If it is too loose, contacts at rest come and go.
double loose_tolerance(const Accuracy& goal);

/// Solvers of this build worth a trial on problems with this number of contacts of this dimension.
std::vector<SolverVariant> promising_solvers(int contacts, int dim);

std::string_view to_string(Advice::Status status);

/// Step and solver together: the sum of their errors. The overlap is that of the advised run, if it
/// was run as a whole, else the larger of both.
MeasuredError expected_error(const Advice& advice);

}  // namespace bipot
