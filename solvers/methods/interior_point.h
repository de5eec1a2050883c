#pragma once

#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kInteriorPointParameters[] = {
    ParameterSpec::number("start_scale", "1", {1e-6, 1e6},
                          "multiplies the impulses of the default start"),
    ParameterSpec::choice(
        "direct", "on", "on|off",
        "begin each round with a proximal interior point from a start of its own"),
    ParameterSpec::choice("paths", "on", "on|off",
                          "follow central paths through their folds, in turns"),
    ParameterSpec::choice("polish", "on", "on|off",
                          "active set and proximal Newton where the error is below 1e-5"),
    ParameterSpec::integer("order", "15", {2, 40}, "order of a path's Taylor series", "orders"),
    ParameterSpec::integer(
        "rounds", "6", {1, 30},
        "rounds of all paths before giving up; each doubles the series of a turn", "rounds"),
    ParameterSpec::choice("linear_system", "auto", "auto|body|contact",
                          "eliminate the contacts (needs a diagonal A), or the bodies"),
};

/// Primal-dual interior point on the exact Coulomb law, d = 1, 2, 3. One iteration is one
/// factorisation, and each is judged; the estimate of the start takes one more. The solver runs
/// rounds of two stages until one meets the stop test:
///
///   1. Direct: the proximal interior point (proximal_interior_point.h) from an equal-product start
///      (equal_product_start.h), once more from a larger or smaller one where that was far away.
///      Later rounds try 10, 0.1 and 100 times the start.
///   2. Paths (taylor_path.h): the central path from equal products, followed through its folds by
///      Taylor series, the method and the finding of Nguyen, Armand and Acary (2025). The path of
///      the exact law is analytic, leads to a solution and is not monotone. Which path is short is
///      not known beforehand. Therefore several alternate: from near the force network of a rough
///      impulse, and the cold one from products ten times the energy of the spring estimate. The
///      rough impulse is the best one so far if its error is below 1e-2, else that of up to 2000
///      iterations of apgd, which are not counted. A path continues while t decreases fast. If the
///      network is bad the cold path comes first, and the others join in a later round.
/// Endgame of a path whose error is below 1e-4, and again at every decade below: active set
/// (active_set.h, below 1e-5), proximal interior point, active set.
///
/// A start s0 with an error below 1e-5 goes to the active set and to proximal Newton
/// (proximal_newton.h). Limits: an end at a solution is not guaranteed (a path may be too long, or
/// none exist); the status is then kStalled. Contacts with mu = 0 have one pair only, no
/// regularised friction. d = 3 is the same in the algebra of the Lorentz cone. Related: Acary,
/// Armand, Nguyen and Shpakovych (2024) solve the associated cone program by an interior point;
/// Acary, Cadoux, Lemaréchal and Malick (2011) iterate on such programs.
void solve_interior_point(SolveRun& run);

}  // namespace bipot
