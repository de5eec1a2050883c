#pragma once

#include "solvers/methods/proximal_point.h"

namespace bipot {

inline constexpr ParameterSpec kPdasParameters[] = {
    ParameterSpec::integer("set_changes", "30", {1, 1e9},
                           "changes of the sets at one kappa, at most", "iterations"),
    kKappaParameter, kLargestKappaParameter};

/// Primal-dual active sets (Hintermüller, Ito and Kunisch 2002; for frictional contact of rigid
/// bodies Abide, Barboteu, Cherkaoui, Danan and Dumont, Comput. Methods Appl. Mech. Eng. 387,
/// 2021). With z = s - c u, c = 1/W_cc, a contact is
///
///     open    z_n <= 0:            s = 0
///     stick   |z_t| <= mu z_n:     u = 0
///     slip    else:                u_n = 0,   s_t = mu s_n z_t / |z_t|
///
/// One linear solve finds s for given sets, and its z the next sets. In the plane these equations
/// are linear. In space the direction of sliding is linearised, as in a semismooth Newton method.
///
/// [ours] W is singular in packings. Therefore the sets belong to the regularised problem of
/// proximal_point.h, with its loop over kappa: u + W_cc (s - s_k) / kappa in place of u, and
/// c = kappa / W_cc, so that z = s_k - kappa u / W_cc. Sets that come back, or change more than
/// `set_changes` times, are a failure: kappa falls, and kappa below its minimum is kStalled. While
/// the best error has not halved for 500 solves, the loop begins again at the best impulse with
/// kappa up to a hundredth of its bound. A bound below 1 is the end, kStalled.
///
/// An iteration is one linear solve, in the bodies where A is diagonal (shifted_delassus.h).
/// Limits: no proof of convergence with friction.
void solve_pdas(SolveRun& run);

}  // namespace bipot
