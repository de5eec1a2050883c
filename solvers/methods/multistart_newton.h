#pragma once

#include "solvers/solver.h"

namespace bipot {

/// Practical limit of dense least squares in d unknowns for each contact.
inline constexpr int kMultistartMaxContacts = 100;

inline constexpr ParameterSpec kMultistartNewtonParameters[] = {
    ParameterSpec::integer("starts", "1000", {1, 1e9}, "starts that are tried"),
    ParameterSpec::integer("steps_each", "60", {1, 1e9}, "Newton steps from each, at most"),
    ParameterSpec::integer("seed", "1", {0, 1e9}, "of the random starts"),
};

/// Exact answers of small problems, d = 1, 2, 3, by semismooth Newton steps on the map of Alart and
/// Curnier (1991). The starts are s0, the result of sweeps, and then alternately random impulses
/// and the best impulse with some contacts drawn again, until one succeeds. It complements `lemke`,
/// which is for 2D.
///
/// In equilibrated impulses x and velocities w (contact_scaling.h), for each contact
///
///     x = 0                                        if x_n - w_n / max(1, mu) <= 0, else
///     w_n = 0,   w_t = 0                           if |x_t - w_t| <= mu x_n,   else
///     w_n = 0,   x_t = mu x_n (x_t - w_t) / |x_t - w_t|
///
/// An impulse that friction multiplies by mu >> 1 is small. Therefore the augmentation of the
/// normal part is divided by mu, and its unknown is mu x_n. With equal augmentations, Newton's
/// method loses as many digits as mu has (mu = 1e6). [ours]
///
/// Steps are least-squares solutions of least norm over the closed contacts, so that W may be
/// singular. After the first steps of a start, a random part of the contacts that require another
/// status get it, because pure steps end in cycles. [ours] A start is given up if ten steps did not
/// lower their number. An iteration is one step, or one of up to 1000 sweeps before the first start
/// (for s0 other than 0: the second).
void solve_multistart_newton(SolveRun& run);

}  // namespace bipot
