#pragma once

#include "core/problem/delassus.h"
#include "solvers/interior/interior_run.h"
#include "solvers/systems/shifted_delassus.h"

namespace bipot {

/// Newton's method in pseudo-time (pseudo-transient continuation: Kelley and Keyes, SIAM J. Numer.
/// Anal. 35, 1998) for the equation of Alart and Curnier (1991). With the anchor a, its equation is
///
///     f(s) = proj(a - rho u(s)) - s = 0,   rho = 1 / (delta W_cc),   u = W s + u_free,
///
/// proj as in split_projection(). A Newton step costs one factorisation of I + J rho W, J the
/// Jacobian of proj. Once |f| has halved, s is the next anchor, and delta falls by the more, the
/// fewer steps were needed: near a solution each step moves the anchor, and 1/delta grows to 1e6.
/// A step that does not halve |f| is shortened. If even that does not help, delta grows fourfold and
/// is approached again by small factors only. [ours] The tangents have five times the weight.
///
/// Limits: it converges from errors of some 1e-2; from far away it may wander without progress.
///
/// `weights`: the diagonal of W, tangents averaged. The run judges every step, at most
/// `max_iterations`. kStuck: rounding forbids more, or no delta helps.
StageEnd proximal_newton(const ContactProblem& problem, const DelassusOperator& delassus,
                         ShiftedDelassus& shifted, const Vector& weights, const Vector& start,
                         InteriorRun& run, int max_iterations);

}  // namespace bipot
