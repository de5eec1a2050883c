#pragma once

#include "solvers/homotopy/law_point.h"

namespace bipot {

/// The diagonal of the proximal term of a path from an anchor (path_follower.h), m values > 0 into
/// `term`, in the units of the LawProblem: delta times
///
///   * the mean normal impulse of the contacts that bear any, over the contact's own, 0.1 to 10: what
///     the term lets a contact give is a velocity, and the criterion counts s_n |u_n|;
///   * a tenth where the point sticks well inside the cone: in a dense packing it is rigid there,
///     and what it gives changes the cells of others.
///
/// An anchor that bears nothing has the first factor 1. [ours]
void proximal_term(const LawProblem& problem, const LawPoint& point, const Vector& anchor,
                   double delta, Vector& term);

}  // namespace bipot
