#pragma once

#include "solvers/solver.h"

namespace bipot {

/// Measured limit of dense least squares in d unknowns a contact: a step takes 4 ms at 50 contacts
/// in space, 30 ms at 100.
inline constexpr int kMultistartMaxContacts = 100;

inline constexpr ParameterSpec kMultistartNewtonParameters[] = {
    {"starts", ParameterSpec::Kind::kInteger, "1000", "", 1, 1e9, "starts that are tried"},
    {"steps_each", ParameterSpec::Kind::kInteger, "60", "", 1, 1e9,
     "Newton steps from each, at most"},
    {"seed", ParameterSpec::Kind::kInteger, "1", "", 0, 1e9, "of the random starts"}};

/// Exact answers of small problems, d = 1, 2, 3: semismooth Newton steps on the map of Alart and
/// Curnier (1991), from s0, from sweeps, and then by turns from random impulses and from the best impulse with some contacts drawn
/// anew, until one of them arrives. It complements
/// `lemke`, which is for the plane.
///
/// In equilibrated impulses x and velocities w (contact_scaling.h), per contact
///
///     x = 0                                        where x_n - w_n / max(1, mu) <= 0, else
///     w_n = 0,   w_t = 0                           where |x_t - w_t| <= mu x_n,   else
///     w_n = 0,   x_t = mu x_n (x_t - w_t) / |x_t - w_t|
///
/// An impulse that friction multiplies by mu >> 1 is small: the augmentation of the normal part is
/// divided by mu, and its unknown is mu x_n. With equal augmentations, Newton's method, and what it
/// polishes, loses as many digits as mu has (mu = 1e6). [ours]
///
/// Steps are least-squares solutions of least norm over the closed contacts, so that W may be
/// singular. From the seventh step of a start on only a drawn share of the contacts that ask for
/// another status get it, because pure steps end in cycles. [ours] A start is left when ten steps
/// did not lower the number of those that ask. The first one begins where up to 1000 sweeps of
/// Gauss and Seidel from s0 end (from a start that is not 0: the second one). An iteration is one
/// step or one such sweep.
void solve_multistart_newton(SolveRun& run);

}  // namespace bipot
