#pragma once

#include <functional>
#include <memory>

#include "solvers/simulation/scene_run.h"

namespace bipot {

/// Takes the steps of a scene in parts of unequal size, so that an impact, and a radius of way,
/// misplace no body by more than about `accuracy` radii (data/manual/explanation/accuracy.md).
///
/// An impact in the middle of a part is exact. Elsewhere the overlap in the middle, where the
/// impact is noticed, is its error. Parts therefore end so that the next one has a collision in its
/// middle (core/motion/closing_pairs.h). Smooth motion is judged by the drift of contacts that
/// stay, and by the change of accelerations. A part that misses the accuracy is taken again,
/// shorter.
///
/// Every step begins with a short part and forgets the last one: the same state gives the same
/// parts, so that a restart continues bit for bit. Sums and contacts: as in summed_parts.h; a pair
/// that is not in the last part has the status kTakeOff.
template <int D>
class AccurateStepper {
 public:
  /// `options`: explicit_delassus, threads, on_failure. `is_over` is polled before each part. The
  /// scene must outlive the stepper.
  AccurateStepper(const Scene<D>& scene, const SceneRunOptions<D>& options, StepSolver solver,
                  std::function<bool()> is_over);
  ~AccurateStepper();

  /// Takes one step. Throws StepFailure, with the state unchanged, as TimeStepper does. Also where
  /// a part would be shorter than the step / 2^20, or an unsolved part may not be taken.
  StepReport<D> advance(State<D>& state);
  /// The contact problem of the last part.
  const ContactProblem& problem() const;

 private:
  struct Inside;
  std::unique_ptr<Inside> inside_;
};

}  // namespace bipot
