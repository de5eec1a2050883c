#pragma once

#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kGaussSeidelParameters[] = {
    ParameterSpec::choice("local", "projection", "projection|exact",
                          "contact problem: rounds of projected steps, or solved exactly"),
    ParameterSpec::integer("local_iterations", "1", {1, 1000}, "rounds of local = projection",
                           "rounds"),
    ParameterSpec::choice(
        "order", "forward", "forward|symmetric|shuffled|tiled",
        "contacts as they stand, alternately forwards and backwards, or drawn anew each sweep; "
        "tiled: disks and spheres in vectors and on threads, tile by tile from both ends of the "
        "packing"),
    ParameterSpec::integer("seed", "1", {0, 4294967295.0}, "of order = shuffled"),
    ParameterSpec::number("omega", "1", {1e-3, 1.999}, "relaxation of each local update"),
    ParameterSpec::choice(
        "operator", "auto", "auto|explicit",
        "body velocities updated in place where A is diagonal, or products with W"),
};

/// Projected block Gauss-Seidel, the NSGS of Jean (Comput. Methods Appl. Mech. Eng. 177, 1999) and
/// Moreau: contact after contact, the contact's own problem is improved or solved with the others
/// frozen, and velocities are refreshed at once. One iteration is one sweep.
///
/// local = projection: rounds of improve_local() (local_coulomb.h) with relaxed steps omega/W_nn
/// and omega/lambda_max(W_tt). local = exact: solve_local(), then s + omega (s_exact - s) projected
/// on K_mu; where the exact solution fails its own check, one round of projection. Disks and
/// spheres have diagonal blocks with equal tangents: one round with omega = 1 is exact there, and
/// both choices are the same.
///
/// order = tiled: a sweep over disks or spheres in vectors and on threads
/// (solvers/disks/tiled_sweep.h), with the same bits for any number of them. Other problems, and
/// more than one round, take their contacts as they stand. Spheres do so in vectors too, contacts
/// without a common body at once.
///
/// For mu = 0 and 0 < omega < 2 each update decreases a convex quadratic and the sweep converges
/// (Luo and Tseng 1992); with friction there is no proof, exact local solutions can cycle where
/// projections converge, and order and omega change what is reached.
///
/// In parallel, order = forward and symmetric: sweeps of all processes at once, with split masses
/// (solvers/parallel/split_sweep.h).
void solve_gauss_seidel(SolveRun& run);
Parallel sweeps_in_parallel(const Parameters& parameters);

}  // namespace bipot
