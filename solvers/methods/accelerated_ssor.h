#pragma once

#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kAcceleratedSsorParameters[] = {
    {.name = "omega",
     .kind = ParameterSpec::Kind::kNumber,
     .default_value = "0",
     .minimum = 0,
     .maximum = 1.999,
     .help = "relaxation of each local update; 0: from the number of contacts"},
    {.name = "sweeps",
     .kind = ParameterSpec::Kind::kInteger,
     .default_value = "2",
     .minimum = 1,
     .maximum = 64,
     .help = "sweeps each way in an iteration, as long as the error falls"},
    {.name = "most_sweeps",
     .kind = ParameterSpec::Kind::kInteger,
     .default_value = "16",
     .minimum = 1,
     .maximum = 64,
     .help = "sweeps each way, where it does not; no fewer than `sweeps`"},
    {.name = "stresses_from",
     .kind = ParameterSpec::Kind::kInteger,
     .default_value = "20000",
     .minimum = 1,
     .maximum = 2e9,
     .help = "contacts of disks in the plane from which on stresses are taken out in the end"},
};

/// Projected Gauss-Seidel forth and back through the contacts, over-relaxed, with Nesterov's
/// momentum and adaptive restart. In variables x with a unit diagonal of W (contact_scaling.h), and
/// with S = Bᵐ Fᵐ, m sweeps forth and m sweeps back of the local updates of `pgs`,
///
///     y = x + beta (x - x⁻),          x⁺ = S(y),
///     t⁺ = (1 + sqrt(1 + 4 t²))/2,    beta = (t - 1)/t⁺,
///
/// with t = 1 again whenever (y - x⁺)·(x⁺ - x) > 0. One iteration is 2 m sweeps.
///
/// Without inequalities S is a step with the preconditioner of SSOR, symmetric and positive for any
/// m, so that momentum is stable; Li, Sun and Toh (Math. Program. 175, 2019) extend this to convex
/// programmes. A single sweep is not symmetric: with momentum it diverges on packings of 10^4
/// contacts. Where contacts are visited along the packing and omega = 2/(1 + O(1/n)), n the disks
/// along a side, the condition of the preconditioned operator is O(n) in place of O(n²) (Axelsson,
/// BIT 12, 1972), hence O(sqrt n) = O(N^1/4) iterations in place of O(n) = O(N^1/2) of `apgd`.
///
/// [ours] m = 2 sweeps each way need 0.6 of the iterations of one on packings at rest, and on moving
/// packings half of them; the second follows the first through the cache, or on another thread. 4 to
/// 16 solve moving packings on which fewer stand still (data/manual/results/performance.md).
///
/// [ours] omega = 2/(1 + 11/n), at least 1, at most 1.91 with two sweeps, 1.85 with one, 1.6 with
/// more, with n = (contacts/3)^(1/2), in space ^(1/3): near the best of lattices of 30 to 563 rows;
/// settled piles want 1. So where the best error has not halved for as many iterations as it took so
/// far (at least 200 + 3 n), it begins again with omega = 1 (disks, where omega is above it), then
/// goes on from the best impulse without momentum, and so on in turns, with four times the sweeps and
/// from the second round on with eight times, `most_sweeps` at most.
///
/// [ours] What is left when the error is below 0.5 on packings of 20 000 disks' contacts and more is
/// mostly smooth stresses, which make its iterations O(N^1/4): from there on conjugate gradients with
/// sweeps as preconditioner (omega = 1.5, m = 4 whatever was asked for), deflated by stress fields on a grid of cells of twelve
/// disks (solvers/disks/deflated_sweep.h): 30 to 60 iterations for 180 to 540 on lattices of 100 to 563
/// rows. Where 24 of them do not halve the error the iteration above goes on.
///
/// With friction there is no proof of convergence. Disks run in vectors, contacts along the
/// rows or, where that leaves vectors empty, as they fill them (solvers/disks/contact_tiles.h), with
/// the same bits from every path and for any number of threads; other problems contact after contact
/// in the given order on one.
void solve_accelerated_ssor(SolveRun& run);

}  // namespace bipot
