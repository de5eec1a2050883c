#pragma once

#include <functional>
#include <optional>

#include "core/motion/spring_dashpot.h"
#include "core/motion/time_stepping.h"
#include "solvers/simulation/split_step.h"

namespace bipot {

/// A scene's steps, one at a time, under either model; spheres have rigid contacts only.
template <int D>
class SceneStepper {
 public:
  /// `solver` solves the steps' problems, with rigid contacts whatever the scene's model is; empty:
  /// the model and the solver are the scene's own choice, which `cancelled` interrupts.
  /// `explicit_delassus`: `solver` needs W. `threads`: of detection, assembly and the scene's own
  /// solver. The scene must outlive the stepper. Throws
  /// std::invalid_argument when the scene's solver or springs are refused.
  explicit SceneStepper(const Scene<D>& scene, StepSolver solver = {},
                        bool explicit_delassus = false, std::function<bool()> cancelled = {},
                        int threads = 1, OnFailure on_failure = OnFailure::kContinue);
  SceneStepper(const SceneStepper&) = delete;  // the solver knows where start_ is
  SceneStepper& operator=(const SceneStepper&) = delete;

  /// Takes one step, see TimeStepper::advance() and SpringDashpotStepper::advance(); what happens
  /// where it is not solved, with rigid contacts, is on_failure's choice.
  StepReport<D> advance(State<D>& state);

  /// Of the last step; without contacts under the model dem.
  const ContactProblem& problem() const { return rigid_ ? rigid_->problem() : none_; }
  /// Impulse that the solver of the last step started from; empty: none was given.
  const Vector& start() const { return start_; }
  /// Of the last step: more than 1 where it was split.
  int parts() const { return parts_; }
  /// Model dem only.
  std::optional<SpringDashpotSetup> springs() const;

 private:
  std::optional<SpringDashpotStepper> springs_;  // in the plane only
  std::optional<TimeStepper<D>> rigid_;
  const Scene<D>& scene_;
  StepSolver solver_;
  bool explicit_delassus_ = false;
  int threads_ = 1;
  OnFailure on_failure_ = OnFailure::kContinue;
  int parts_ = 1;
  Vector start_;
  ContactProblem none_;
};

}  // namespace bipot
