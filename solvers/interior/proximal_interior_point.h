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
extern template StageEnd proximal_interior_point<ContactRows(3, true)>(
    InteriorSystem<ContactRows(3, true)>&, InteriorState<ContactRows(3, true)>&, InteriorRun&,
    const ProximalInteriorPointOptions&, InteriorState<ContactRows(3, true)>&);
extern template StageEnd proximal_interior_point<ContactRows(6, true)>(
    InteriorSystem<ContactRows(6, true)>&, InteriorState<ContactRows(6, true)>&, InteriorRun&,
    const ProximalInteriorPointOptions&, InteriorState<ContactRows(6, true)>&);

}  // namespace bipot
