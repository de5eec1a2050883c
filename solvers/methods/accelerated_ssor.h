#pragma once

#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kAcceleratedSsorParameters[] = {
    ParameterSpec::number("omega", "0", {0, 1.999},
                          "relaxation of each local update; 0: from the number of contacts"),
    ParameterSpec::integer("sweeps", "2", {1, 64},
                           "sweeps each way in an iteration, as long as the error falls"),
    ParameterSpec::integer("most_sweeps", "16", {1, 64},
                           "sweeps each way, where it does not; no fewer than `sweeps`"),
    ParameterSpec::integer(
        "stresses_from", "20000", {1, 2e9},
        "contacts of disks in the plane from which on stresses are taken out in the end"),
};

/// Symmetric projected Gauss-Seidel, over-relaxed, with Nesterov's momentum and adaptive restart.
/// In variables x with a unit diagonal of W (contact_scaling.h), and with S = Bᵐ Fᵐ, m forward and
/// m backward sweeps of the local updates of `pgs`,
///
///     y = x + beta (x - x⁻),          x⁺ = S(y),
///     t⁺ = (1 + sqrt(1 + 4 t²))/2,    beta = (t - 1)/t⁺,
///
/// with t = 1 again whenever (y - x⁺)·(x⁺ - x) > 0. One iteration is 2 m sweeps.
///
/// Without inequalities S is a step with the preconditioner of SSOR, symmetric and positive for any
/// m, so that momentum is stable. Li, Sun and Toh (Math. Program. 175, 2019) extend this to convex
/// programmes. A single sweep is not symmetric: with momentum it diverges on packings of 10^4
/// contacts. Let contacts be visited along the packing and omega = 2/(1 + O(1/n)), n the disks
/// along a side. Then the condition of the preconditioned operator is O(n) in place of O(n²)
/// (Axelsson, BIT 12, 1972). Hence O(sqrt n) = O(N^1/4) iterations suffice, in place of O(n) =
/// O(N^1/2) of `apgd`.
///
/// [ours] The default is m = 2: the second sweep follows the first through the cache, or on another
/// thread. m = 4 to 16 is more robust on moving packings (data/manual/results/performance.md).
///
/// [ours] omega = 2/(1 + 11/n), at least 1, at most 1.6 to 1.91 by the sweeps, with n =
/// (contacts/3)^(1/2), in 3D ^(1/3). This suits lattices; settled piles need 1. Therefore it restarts
/// with omega = 1 if it stagnates, then continues from the best impulse without momentum, and so on
/// in turn. Later variants have more sweeps.
///
/// [ours] On packings of disks with 20 000 contacts and more, the error below 0.5 is mostly due to
/// smooth stresses, which cause the O(N^1/4) iterations. There conjugate gradients continue, with
/// sweeps as preconditioner (omega = 1.5, m = 4), deflated by stress fields on a grid with cells of
/// twelve disks (solvers/disks/deflated_sweep.h). If 24 of these do not halve the error, the
/// iteration above continues.
///
/// Limits: with friction convergence is not proved. Disks and spheres run in vectors, with contacts
/// along the rows or, if that leaves lanes empty, in the order that fills them
/// (solvers/disks/contact_order.h). Every path and any number of threads give the same bits. Other
/// problems run contact after contact in the given order on one thread.
void solve_accelerated_ssor(SolveRun& run);

}  // namespace bipot
