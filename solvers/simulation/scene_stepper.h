#pragma once

#include <optional>

#include "core/base/stopwatch.h"
#include "core/motion/spring_dashpot.h"
#include "solvers/simulation/domain.h"
#include "solvers/simulation/scene_run.h"
#include "solvers/simulation/step_solver.h"

namespace bipot {

/// A scene's steps, one at a time, under either model; spheres have rigid contacts only.
template <int D>
class SceneStepper {
 public:
  /// Of the options: all but number of steps, folder and callbacks. The scene must outlive the
  /// stepper. Throws std::invalid_argument when the scene's solver or springs are refused.
  explicit SceneStepper(const Scene<D>& scene, SceneRunOptions<D> options = {});
  SceneStepper(const SceneStepper&) = delete;  // the solver knows where start_ is
  SceneStepper& operator=(const SceneStepper&) = delete;

  /// Where the state is to lie on several processes: takes this one's part of `state`, which
  /// becomes empty. That part is to be advanced, and is returned; else `state`.
  State<D>& begin(State<D>& state);
  /// Takes one step, see TimeStepper::advance() and SpringDashpotStepper::advance(); on_failure
  /// decides about a step that is not solved, with rigid contacts.
  StepReport<D> advance(State<D>& state);
  /// Whether the run is cancelled or its time is up, on any process.
  bool is_over() const;

  /// Of the last step; without contacts under the model dem.
  const ContactProblem& problem() const { return rigid_ ? rigid_->problem() : none_; }
  /// Impulse that the solver of the last step started from; empty: none was given.
  const Vector& start() const { return start_; }
  /// Of the last step: more than 1 where it was split.
  int parts() const { return parts_; }
  /// Model dem only; else null.
  std::shared_ptr<const SpringDashpotSetup> springs() const;
  /// Null where this process has the whole state.
  Domain<D>* domain() { return domain_ ? &*domain_ : nullptr; }

 private:
  const Scene<D>& scene_;
  SceneRunOptions<D> options_;
  Stopwatch watch_;
  RunSolver own_;                                // the scene's choice of solver
  std::optional<SpringDashpotStepper> springs_;  // in the plane only
  std::optional<Domain<D>> domain_;
  std::optional<TimeStepper<D>> rigid_;
  int parts_ = 1;
  Vector start_;
  ContactProblem none_;
};

}  // namespace bipot
