#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/advise/advice.h"
#include "core/scene/scene.h"

namespace bipot {

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
};

/// What was seen of the scene on a run with `auto`.
struct SceneSample {
  int steps_planned = 0, steps_run = 0;
  int contact_steps = 0;  ///< of those run, with contacts
  int contacts_max = 0;
  double overhead_seconds = 0;  ///< of a step besides its solve: detection, assembly   [s]
  std::string note;             ///< why the run ended early; empty: it did not
};

/// Errors of time steps: from sampled states over a window of time, steps of 4, 2, 1, ½, ¼ of the
/// scene's against the finest that time allows (⅛), all solved tightly. Over the window,
///   force:       largest difference of a body's mean contact force (hat-shaped weight, so that a
///                shock that moves from one step to the next counts by its time), over the largest
///                such force on a body; the worst window;
///   penetration: largest overlap that one step adds to a pair; the worst window. Exact: 0;
///   energy:      sum over the windows of the differences in dissipated energy, over the sum of
///                the energies.
/// Differences are scaled by r/(r - 1), r the ratio of the steps, as the reference has an error of
/// first order as well.
struct StepStudy {
  double window = 0;             ///< [s]: a fiftieth of the run, at least 16 of the scene's steps
  int windows = 0;               ///< that all entries of `steps` were measured on
  int windows_dropped = 0;       ///< a solve in them failed, or time was short
  double finest = 0;             ///< factor of the reference
  std::vector<StepTrial> steps;  ///< from large to small
};

struct Advice {
  enum class Status { kMet, kNotMet, kNoContacts, kInterrupted };
  Status status = Status::kNotMet;
  std::string message;  ///< one sentence: what could not be met and the best that can, or how it is
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
  int several_solutions = 0;    ///< problems left out of the errors: two references disagree
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

/// Solvers worth a trial on problems of so many contacts, those of this build.
std::vector<SolverVariant> promising_solvers(int contacts);

/// Tries solvers, tolerances and time steps on the scene's own steps and recommends the cheapest
/// that meets the goal. Times decide, so that two runs may differ in close calls; errors do not
/// depend on them. Throws std::invalid_argument for a goal or options that make no sense.
Advice advise(const Scene& scene, const AdviseOptions& options);

}  // namespace bipot
