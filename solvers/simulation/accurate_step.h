#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/motion/closing_pairs.h"
#include "solvers/simulation/scene_run.h"

namespace bipot {

/// Takes the steps of a scene in parts of unequal size, so that an impact, and a radius of way,
/// misplace no body by more than about `accuracy` radii (data/manual/explanation/accuracy.md has the
/// method). A part that misses the accuracy is taken again, shorter.
///
/// Every step begins with a short part and forgets the last one: the same state gives the same
/// parts, so that a restart continues bit for bit. Sums and contacts: as in summed_parts.h; a pair
/// that is not in the last part has the status kTakeOff.
template <int D>
class AccurateStepper {
 public:
  /// `options`: threads, on_failure. `is_over` is polled before each part. The
  /// scene must outlive the stepper.
  AccurateStepper(const Scene<D>& scene, const SceneRunOptions<D>& options, StepSolver solver,
                  std::function<bool()> is_over);
  AccurateStepper(const AccurateStepper&) = delete;  // the stepper of parts knows where part_ is
  AccurateStepper& operator=(const AccurateStepper&) = delete;

  /// Takes one step. Throws StepFailure, with the state unchanged, as TimeStepper does. Also where
  /// a part would be shorter than the step / 2^20, or an unsolved part may not be taken.
  StepReport<D> advance(State<D>& state);
  /// The contact problem of the last part.
  const ContactProblem& problem() const { return stepper_.problem(); }

 private:
  struct Step;
  struct Part;
  struct Error;

  std::string impact(const State<D>& state, int i, int j) const;
  std::string place(const State<D>& now, const std::vector<Closing<D>>& closing, double& h) const;
  Error measure(const Step& step, const Part& taken, const State<D>& after,
                const Accelerations<D>& a_after);
  Part next_part(const Step& step);
  std::string take(const Step& step, double h, State<D>& next, StepReport<D>& report);
  bool rejects(const Error& error, double h, const State<D>& next, Step& step) const;
  void go_on(const Part& taken, const Error& error, const Accelerations<D>& a, Step& step) const;

  const Scene<D>& scene_;
  const SceneRunOptions<D> options_;
  const std::function<bool()> is_over_;
  Scene<D> part_;  // the scene with the size of a part as its step, without gates
  TimeStepper<D> stepper_;
  ClosingPairs<D> closings_;
  const double longest_;  // part [s]
  const double radius_;   // the smallest [m]
};

}  // namespace bipot
