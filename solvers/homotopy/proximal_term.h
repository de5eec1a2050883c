#pragma once

#include "solvers/homotopy/law_point.h"

namespace bipot {

/// The diagonal of the proximal term of a path from an anchor (path_follower.h): m values > 0 into
/// `term`, in the units of the LawProblem. It is delta times
///
///   * the mean normal impulse of the loaded contacts over the contact's own, 0.1 to 10: the term
///     allows a velocity of the contact, and the criterion counts s_n |u_n|;
///   * a tenth for points that stick well inside the cone: a dense packing is rigid there, and a
///     larger term changes the cells of others.
///
/// An unloaded anchor has the first factor 1. [ours]
void proximal_term(const LawProblem& problem, const LawPoint& point, const Vector& anchor,
                   double delta, Vector& term);

}  // namespace bipot
