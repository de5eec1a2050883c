#pragma once

#include "solvers/solve_run.h"

namespace bipot {

/// Shared state of the stages of the interior-point solver: the judge, and the count of
/// factorisations. One iteration is one factorisation whose impulse is judged. A factorisation that
/// a stage discards (a larger proximal term, a path that turns back) counts for the following
/// stage.
class InteriorRun {
 public:
  explicit InteriorRun(SolveRun& r) : run(r) {}
  SolveRun& run;
  int iteration = 0;

  /// Counts one iteration and judges its impulse; true: end the solve.
  bool next(const Vector& s, double step) {
    judged_ = run.due(++iteration);
    // Slacks, multipliers and delta change even if s does not: an equal s is no stall here.
    return run.stop(iteration, s, step, /*moving=*/true);
  }
  /// True if the last iterate was judged: the monitor's last error is then its own.
  bool judged() const { return judged_; }

 private:
  bool judged_ = false;
};

enum class StageEnd {
  kStop,        ///< the run is over
  kLimit,       ///< the stage's own budget of iterations is used
  kStuck,       ///< no step is possible or no progress is made
  kFailed,      ///< a factorisation failed or a value is not finite
  kSmallStart,  ///< still far away: the forces of the start were too small
  kLargeStart,  ///< the same, too large
};

}  // namespace bipot
