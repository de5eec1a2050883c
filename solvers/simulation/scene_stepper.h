#pragma once

#include <optional>

#include "core/base/stopwatch.h"
#include "core/motion/spring_dashpot.h"
#include "solvers/simulation/accurate_step.h"
#include "solvers/simulation/domain.h"
#include "solvers/simulation/joint_energy.h"
#include "solvers/simulation/scene_run.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {

/// Takes the steps of a scene, one at a time, with either model.
template <int D>
class SceneStepper {
 public:
  /// Uses all options but number of steps, folder and callbacks. The scene must outlive the
  /// stepper. Throws std::invalid_argument if the scene's solver or springs are refused.
  explicit SceneStepper(const Scene<D>& scene, SceneRunOptions<D> options = {});
  SceneStepper(const SceneStepper&) = delete;  // the solver knows where start_ is
  SceneStepper& operator=(const SceneStepper&) = delete;

  /// Distributes the state if possible: takes this process's part of `state`, which becomes empty,
  /// and returns that part to advance; else returns `state`.
  State<D>& begin(State<D>& state);
  /// Takes one step, see TimeStepper::advance() and SpringDashpotStepper::advance(). on_failure
  /// applies to an unsolved step with rigid contacts.
  StepReport<D> advance(State<D>& state);
  /// TimeStepper::name_overlaps_beyond() of steps that are taken as a whole.
  void name_overlaps_beyond(double overlap) {
    if (rigid_) rigid_->name_overlaps_beyond(overlap);
  }
  /// True if the run is cancelled or its time is over, on any process.
  bool is_over() const;

  /// Problem of the last step; without contacts for the model dem. Of a step that was cut: the
  /// first one that was not solved, of the whole step or of a part, else that of the last part.
  const ContactProblem& problem() const {
    return cut_ ? *cut_ : accurate_ ? accurate_->problem() : rigid_ ? rigid_->problem() : none_;
  }
  /// Impulse from which the solver of that problem started; empty: none.
  const Vector& start() const { return start_; }
  /// Number of parts of the last step that failed as a whole or has a `travel`.
  int parts() const { return parts_; }
  /// Model dem only; else null.
  std::shared_ptr<const SpringDashpotSetup> springs() const;
  /// Null if this process has the whole state.
  Domain<D>* domain() { return domain_ ? &*domain_ : nullptr; }

 private:
  /// Marks the answer to a problem that was not solved, if this provably has no solution; the same
  /// on all processes. `problem` is asked for by the first one only, of all of them.
  void seek_proof(const std::function<ContactProblem()>& problem, StepSolution& solution);
  /// advance() without a look at the energy that joints make.
  StepReport<D> take(State<D>& state);
  StepReport<D> take_rigid(State<D>& state);
  /// The options with a solver that remembers problem() of a step that is cut from now on.
  SceneRunOptions<D> options_of_parts();

  const Scene<D>& scene_;
  SceneRunOptions<D> options_;
  Stopwatch watch_;
  RunSolver own_;  // the scene's choice of solver
  std::optional<SpringDashpotStepper<D>> springs_;
  std::optional<Domain<D>> domain_;
  std::optional<TimeStepper<D>> rigid_;
  std::optional<AccurateStepper<D>> accurate_;  // instead, for a scene with an accuracy
  int parts_ = 1;
  double proof_seconds_ = 0;  // used
  Vector start_;
  JointEnergy joint_energy_;
  std::optional<ContactProblem> cut_;  // problem() of a step that was cut
  bool cut_is_unsolved_ = false;
  ContactProblem none_;
};

}  // namespace bipot
