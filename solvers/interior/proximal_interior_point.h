#pragma once

#include "solvers/interior/interior_run.h"
#include "solvers/interior/interior_state.h"

namespace bipot {

struct ProximalInteriorPointOptions {
  int max_iterations = 150;
  int patience = 40;  ///< kStuck after this many iterations without halving the best error
  /// kStuck once error / best error exceeds this, if the best is below 1e-2: far away it may rise.
  double largest_growth = kInfinity;
  /// kSmallStart or kLargeStart if the error is above 1 after this many iterations; the stagnation
  /// test begins then. 0: it begins at once.
  int far_iterations = 0;
};

/// Proximal interior point ("PIP"): infeasible Mehrotra predictor-corrector on the exact law, with
/// a proximal term delta W_cc ds whose anchor is the current impulse. delta is raised until the
/// determinant of the Newton matrix is positive (beyond a fold of the central path it is not). It
/// falls again while long steps succeed. tau is held or raised while the kinematic residual is
/// larger than the products, which moves the iterate out of corners. `best` receives the state with
/// the smallest guarded error.
template <ContactRows D>
struct ProximalInteriorPoint {
  InteriorSystem<D>& system;
  InteriorRun& run;

  StageEnd operator()(InteriorState<D>& z, const ProximalInteriorPointOptions& options,
                      InteriorState<D>& best);
};
template <ContactRows D>
ProximalInteriorPoint(InteriorSystem<D>&, InteriorRun&) -> ProximalInteriorPoint<D>;

}  // namespace bipot
