#pragma once

#include "solvers/interior/interior_state.h"
#include "solvers/monitor.h"

namespace bipot {

/// What the stages of the interior-point solver share: who judges, and the count of factorisations.
class InteriorRun {
 public:
  explicit InteriorRun(IterationMonitor& m) : monitor(m) {}
  IterationMonitor& monitor;
  int iteration = 0;

  /// Counts one iteration and judges its impulse; true: stop everything.
  bool next(const Vector& s, double step) {
    judged_ = monitor.due(++iteration);
    // Slacks, multipliers and delta change also where s does not: an equal s is no stall here.
    return monitor.stop(iteration, s, step, /*moving=*/true);
  }
  /// Whether the last iterate was judged: the monitor's last error is then its own.
  bool judged() const { return judged_; }

 private:
  bool judged_ = false;
};

enum class StageEnd {
  kStop,    ///< the monitor said stop
  kLimit,   ///< the stage's own budget of iterations is used
  kStuck,   ///< no step is possible or no progress is made
  kFailed,  ///< a factorisation failed or a value is not finite
};

struct ProximalInteriorPointOptions {
  int max_iterations = 150;
  double neighbourhood = 1e-3;  ///< smallest product over the mean one
  int patience = 40;            ///< kStuck after so many iterations without halving the best error
  double final_gap = 0;         ///< kLimit once the gap (all products and residuals over a tenth of
                                ///< the energy that the impulses move) is below
  double delta_floor = 1e-7;    ///< smallest proximal term, in units of 1/W
};

/// Proximal interior point ("PIP"): infeasible Mehrotra predictor-corrector on the exact law, with
/// a proximal term delta W_cc ds whose anchor is the current impulse. delta is raised until the
/// determinant of the Newton matrix is positive (beyond a fold of the central path it is not), and
/// falls again while long steps succeed. tau is held or raised while the kinematic residual is
/// larger than the products, which takes the iterate out of corners. `best` receives the state with
/// the smallest guarded error.
template <int D>
StageEnd proximal_interior_point(InteriorSystem<D>& system, InteriorState<D>& z, InteriorRun& run,
                                 const ProximalInteriorPointOptions& options,
                                 InteriorState<D>& best);

extern template StageEnd proximal_interior_point<1>(InteriorSystem<1>&, InteriorState<1>&,
                                                    InteriorRun&,
                                                    const ProximalInteriorPointOptions&,
                                                    InteriorState<1>&);
extern template StageEnd proximal_interior_point<2>(InteriorSystem<2>&, InteriorState<2>&,
                                                    InteriorRun&,
                                                    const ProximalInteriorPointOptions&,
                                                    InteriorState<2>&);
extern template StageEnd proximal_interior_point<3>(InteriorSystem<3>&, InteriorState<3>&,
                                                    InteriorRun&,
                                                    const ProximalInteriorPointOptions&,
                                                    InteriorState<3>&);

}  // namespace bipot
