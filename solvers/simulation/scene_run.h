#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>

#include "core/motion/time_stepping.h"
#include "solvers/solver.h"

namespace bipot {

struct DomainCounts;        // solvers/simulation/domain.h
class ProcessGroup;         // solvers/parallel/process_group.h
struct SpringDashpotSetup;  // core/motion/spring_dashpot_setup.h

/// A finished step for observers. With a distributed state it is the whole on the root process for
/// steps whose state the folder writes; and for the first step that did not converge, then with its
/// problem. Else it is a state without bodies.
template <int D>
struct SceneStep {
  const State<D>& state;  ///< after the step
  const StepReport<D>& report;
  const ContactProblem& problem;  ///< of the step or a part of it: SceneStepper::problem()
  const Vector& start;            ///< impulse from which the solver started; empty: none
  bool cut = false;               ///< the step was taken in parts
};

/// Sums and extremes over the steps of a run.
template <int D>
struct SceneTotals {
  int steps = 0, converged = 0;
  long contacts = 0, iterations = 0;
  int max_contacts = 0, max_iterations = 0;
  int split = 0;               ///< steps that were taken in parts
  int first_unconverged = -1;  ///< step; -1: all converged
  int worst_unconverged = -1;  ///< the one with the largest error
  ContactError unconverged;    ///< there
  std::string message;         ///< of that step
  int worst_step = -1;         ///< step with the largest guarded error, or the last undefined one
  ContactError worst;          ///< there
  int unsolvable = 0;          ///< steps that provably have no solution; not converged
  double penetration = 0;      ///< largest of the steps                                  [m]
  double overlap = 0;          ///< the same over the smaller radius
  int overlap_step = -1;       ///< where
  std::string overlap_pair;    ///< there
  int deep_overlaps = 0;       ///< steps beyond kDeepOverlap
  double travel = 0;           ///< largest way of a body in a step over its radius
  int travel_step = -1;        ///< where
  StepParts cut;               ///< sums and extremes of the steps' parts, with an accuracy
  int cut_step = -1;           ///< of its smallest part
  int misplaced_step = -1;     ///< of its largest displacement
  int passages = 0;            ///< pairs that went through each other, and those of the first step
  int passage_step = -1;
  std::string passage;
  double detection_seconds = 0, assembly_seconds = 0, solve_seconds = 0;
  StepReport<D> last;

  void add(const StepReport<D>& report);

 private:
  void add_parts(const StepReport<D>& report);
};

/// Action after a step whose problem was not solved to the tolerance.
enum class OnFailure {
  kContinue,          ///< takes it with the best impulse, and reports it
  kUnlessUnsolvable,  ///< the same, but ends before a step that provably has no solution
  kStop,              ///< does not take it, and ends
  kSmallerStep        ///< takes it in parts; ends if that fails as well
};

/// Action after a step in which bodies or walls went through each other (core/motion/passage.h);
/// rigid contacts only.
enum class OnTunnel {
  kStop,        ///< does not take it, and ends
  kWarn,        ///< takes it, and reports it
  kSmallerStep  ///< takes it in parts; ends if that does not help
};

/// Output folder of a run; data/manual/reference/files.md describes the files.
struct RunFolderOptions {
  enum class Problems { kNone, kFailed, kAll };
  std::filesystem::path folder;  ///< empty: nothing is written
  std::string scene_text;        ///< kept in run.h5
  std::string program;           ///< name and version, kept in the problems' descriptions
  bool resume = false;  ///< the folder is that of the continued run: its files are continued
  Problems problems = Problems::kNone;  ///< contact problems that are written, as FCLIB files
};

template <int D>
struct SceneRunOptions {
  std::optional<int> steps;  ///< number of steps; by default that of the scene
  /// Solves the problems of the steps, with rigid contacts whatever the scene's model is; empty:
  /// the model and the solver are those of the scene.
  StepSolver solver;
  int threads = 1;  ///< of detection, assembly and the scene's own solver
  OnFailure on_failure = OnFailure::kContinue;  ///< rigid contacts only
  /// Wall time, in all, to seek proofs that unsolved steps have no solution; 0: none is sought. For
  /// the scene's own solver; of smaller steps where the smallest failed.               [s]
  double proof_seconds = 0;
  OnTunnel on_tunnel = OnTunnel::kStop;
  /// Polled before each step, and inside by the scene's own solver or model; true ends the run.
  std::function<bool()> cancelled;
  double time_limit = kInfinity;  ///< for all steps, likewise                             [s]
  /// Processes that run the scene together from the same state; null: this one alone. Callbacks
  /// must agree on all.
  ProcessGroup* processes = nullptr;
  bool reproducible = false;  ///< exact sums, the same bits for any number of processes
  RunFolderOptions folder;    ///< written by the first process
  /// Called before each step; may change the impulses from which the step starts.
  std::function<void(State<D>&)> before_step;
  std::function<bool(const SceneStep<D>&)> on_step;          ///< false ends the run after this step
  std::function<void(const IterationRecord&)> on_iteration;  ///< of the scene's own solver

  /// True if a step is taken although its problem was not solved.
  bool takes_unsolved() const {
    return on_failure == OnFailure::kContinue || on_failure == OnFailure::kUnlessUnsolvable;
  }
};

template <int D>
struct SceneRun {
  enum class End {
    kCompleted,  ///< all steps were taken
    kStopped,    ///< on_step said so
    /// `cancelled` returned true, the time is over, or the solver of a step was cut short.
    kCancelled,
    kFailed  ///< a step could not be taken
  };
  End end = End::kCompleted;
  SceneTotals<D> totals;
  int planned = 0;                     ///< steps
  std::optional<StepFailure> failure;  ///< of the failed step, if any
  ContactProblem failed_problem;       ///< its problem and start; empty for the model dem
  Vector failed_start;
  std::shared_ptr<const SpringDashpotSetup> springs;  ///< model dem only
  std::shared_ptr<const DomainCounts> domains;        ///< where the state lay on several processes
  double output_seconds = 0;                          ///< wall time that the steps waited for files
};

/// Reason, as text for the command line, why a process keeps the whole state; empty if each of
/// several has its part.
template <int D>
std::string needs_whole_state(const Scene<D>& scene,
                              const std::type_identity_t<SceneRunOptions<D>>& options);

/// Takes the steps of a scene: `state` becomes that at the end of the last whole step. A
/// distributed state ends on the root process, elsewhere without bodies. Throws
/// std::invalid_argument before the first step if the scene's solver or springs are refused. Where
/// `options.processes` is null, also for a fault by validate() or count_mismatch(). FileError if the
/// folder cannot be written. Later failures are part of the result.
template <int D>
SceneRun<D> run_scene(const Scene<D>& scene, State<D>& state,
                      const std::type_identity_t<SceneRunOptions<D>>& options = {});

}  // namespace bipot
