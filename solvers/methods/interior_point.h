#pragma once

#include "core/linear/system_factor.h"
#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kInteriorPointParameters[] = {
    {.name = "start_scale",
     .kind = ParameterSpec::Kind::kNumber,
     .default_value = "1",
     .minimum = 1e-6,
     .maximum = 1e6,
     .help = "multiplies the impulses of the default start"},
    {.name = "direct",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "on",
     .choices = "on|off",
     .help = "begin each round with a proximal interior point from a start of its own"},
    {.name = "paths",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "on",
     .choices = "on|off",
     .help = "follow central paths through their folds, in turns"},
    {.name = "polish",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "on",
     .choices = "on|off",
     .help = "active set and proximal Newton where the error is below 1e-5"},
    {.name = "order",
     .kind = ParameterSpec::Kind::kInteger,
     .default_value = "15",
     .minimum = 2,
     .maximum = 40,
     .help = "order of a path's Taylor series",
     .unit = "orders"},
    {.name = "rounds",
     .kind = ParameterSpec::Kind::kInteger,
     .default_value = "6",
     .minimum = 1,
     .maximum = 30,
     .help = "rounds of all paths before giving up; each doubles the series of a turn",
     .unit = "rounds"},
    {.name = "linear_system",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "auto",
     .choices = "auto|body|contact",
     .help = "eliminate the contacts (needs a diagonal A), or the bodies"},
};

/// Primal-dual interior point on the exact Coulomb law, d = 1, 2, 3. One iteration is one
/// factorisation, each is judged; the start estimate takes one more. Rounds of stages, the first
/// that meets the stop test ends:
///
///   1. Direct: the proximal interior point (proximal_interior_point.h) from an equal-product start
///      (equal_product_start.h), given up after 12 iterations without halving the error, or when
///      the error is above 1 after 10: then once more from products 30 times as large. Packings at
///      rest and two thirds of the flowing ones arrive in 10 to 30 factorisations. Later rounds try
///      10, 0.1 and 100 times the start.
///   2. Paths (taylor_path.h): the central path from equal products, followed through its folds by
///      Taylor series, which is the method and the finding of Nguyen, Armand and Acary (2025): the
///      path of the exact law is analytic, leads to a solution and is not monotone. Which of the
///      paths is short cannot be told beforehand, so several take turns of 30 series, doubled each
///      round: from next to the force network of a rough impulse (the best one so far where its
///      error is below 1e-2, else up to 2000 iterations of apgd, which are not counted; products
///      1e-2, 1e-3, 1e-1 of its energy), and the cold one from products ten times the energy of
///      the spring estimate. A path keeps its turn while t falls fast. Where the network is bad
///      the cold path comes first.
///   Endgame of a path whose error is below 1e-4, and again at every decade below: active set
///   (active_set.h, below 1e-5), proximal interior point, active set.
///
/// A start s0 with an error below 1e-5 is handed to the active set and to proximal Newton
/// (proximal_newton.h). Nothing guarantees an end at a solution (a path may be too long, or none
/// exist): the status says stalled. Contacts with mu = 0 have one pair only, no regularised
/// friction. d = 3 is the same in the algebra of the Lorentz cone.
/// Related: Acary, Armand, Nguyen and Shpakovych (2024) solve the associated cone program by an
/// interior point, Acary, Cadoux, Lemaréchal and Malick (2011) iterate on such programs.
void solve_interior_point(SolveRun& run);

}  // namespace bipot
