#pragma once

#include <functional>
#include <optional>
#include <string>
#include <type_traits>

#include "core/motion/spring_dashpot.h"
#include "core/motion/time_stepping.h"
#include "solvers/simulation/split_step.h"

namespace bipot {

/// A step that was just taken, as those who look on see it.
template <int D>
struct SceneStep {
  const State<D>& state;  ///< after the step
  const StepReport<D>& report;
  const ContactProblem& problem;  ///< of the step; without contacts under the model dem
  const Vector& start;            ///< impulse that the solver started from; empty: none was given
};

/// What the steps of a run add up to.
template <int D>
struct SceneTotals {
  int steps = 0, converged = 0;
  long contacts = 0, iterations = 0;
  int max_contacts = 0, max_iterations = 0;
  int split = 0;               ///< steps that were taken in parts
  int first_unconverged = -1;  ///< step; -1: all converged
  std::string message;         ///< of that step
  int worst_step = -1;         ///< step with the largest guarded error, or the last undefined one
  ContactError worst;          ///< there
  double penetration = 0;      ///< largest of the steps                                  [m]
  double detection_seconds = 0, assembly_seconds = 0, solve_seconds = 0;
  StepReport<D> last;

  void add(const StepReport<D>& report);
};

template <int D>
struct SceneRunOptions {
  std::optional<int> steps;  ///< to take; the scene's number where it is not given
  /// Solves the steps' problems, with rigid contacts whatever the scene's model is; empty: the model
  /// and the solver are the scene's own choice, which `cancelled` interrupts.
  StepSolver solver;
  bool explicit_delassus = false;  ///< `solver` needs W
  int threads = 1;                 ///< of detection, assembly and the scene's own solver
  OnFailure on_failure = OnFailure::kContinue;  ///< rigid contacts only
  std::function<bool()> cancelled;  ///< polled before each step (and by springs inside); true ends
  /// Before each step: may look, and change the impulses that the step starts from.
  std::function<void(State<D>&)> before_step;
  std::function<bool(const SceneStep<D>&)> on_step;  ///< false ends the run after this step
};

template <int D>
struct SceneRun {
  enum class End {
    kCompleted,  ///< all steps were taken
    kStopped,    ///< on_step said so
    kCancelled,  ///< `cancelled` said so, or the solver of a step was cut short
    kFailed      ///< a step could not be taken
  };
  End end = End::kCompleted;
  SceneTotals<D> totals;
  int planned = 0;                     ///< steps
  std::optional<StepFailure> failure;  ///< of the step that was not taken, if one was tried
  ContactProblem failed_problem;       ///< its problem and start; empty under the model dem
  Vector failed_start;
  std::optional<SpringDashpotSetup> springs;  ///< model dem only
  double output_seconds = 0;  ///< wall time that the steps waited for files, run_scene_into() only
};

/// Takes the steps of a scene: `state` goes from what is given to the end of the last whole step.
/// Throws std::invalid_argument when the scene's solver or springs are refused before the first
/// step; what happens later is in the result.
template <int D>
SceneRun<D> run_scene(const Scene<D>& scene, State<D>& state,
                      const std::type_identity_t<SceneRunOptions<D>>& options = {});

}  // namespace bipot
