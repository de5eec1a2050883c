#pragma once

#include "solvers/interior/proximal_interior_point.h"

namespace bipot {

struct ArclengthOptions {
  int max_iterations = 300;
  int patience = 80;           ///< kStuck after so many iterations without halving the smallest t
  double neighbourhood = 0.5;  ///< products stay within this factor of the path's, and its inverse
};

/// Arclength continuation along the weighted central path, through its folds (Allgower and Georg
/// 1990, predictor-corrector form). From an interior state with products c_j and kinematic residual
/// p0 the path is
///
///     X∘Y = t c,   u - U Y = t p0,   t from 1 to 0,
///
/// and its start lies on it. Steps are measured in relative changes of all pairs and of t, because
/// those span many decades. Each iteration takes one factorisation for a tangent, a correction at
/// fixed t and a second-order term. The orientation follows the sign of the determinant of the
/// Newton matrix, which changes exactly where the path folds. For d = 3 the path's right-hand side
/// is the multiple of the identity with the trace of the start's products.
///
/// The path need not lead to a solution: kStuck when it leaves t <= 3 or no step is possible.
/// Near the solution (small t, original orientation) the proximal interior point takes over.
template <int D>
StageEnd follow_central_path(InteriorSystem<D>& system, InteriorState<D> z, InteriorRun& run,
                             const ArclengthOptions& options,
                             const ProximalInteriorPointOptions& endgame, InteriorState<D>& best);

extern template StageEnd follow_central_path<1>(InteriorSystem<1>&, InteriorState<1>, InteriorRun&,
                                                const ArclengthOptions&,
                                                const ProximalInteriorPointOptions&,
                                                InteriorState<1>&);
extern template StageEnd follow_central_path<2>(InteriorSystem<2>&, InteriorState<2>, InteriorRun&,
                                                const ArclengthOptions&,
                                                const ProximalInteriorPointOptions&,
                                                InteriorState<2>&);
extern template StageEnd follow_central_path<3>(InteriorSystem<3>&, InteriorState<3>, InteriorRun&,
                                                const ArclengthOptions&,
                                                const ProximalInteriorPointOptions&,
                                                InteriorState<3>&);

}  // namespace bipot
