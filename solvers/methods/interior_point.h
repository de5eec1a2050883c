#pragma once

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
    {.name = "series_tolerance",
     .kind = ParameterSpec::Kind::kNumber,
     .default_value = "1e-3",
     .minimum = 1e-12,
     .maximum = 0.5,
     .help = "largest relative error of a product within a series' reach"},
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
/// factorisation; the start estimate takes one more. Stages, the first that meets the stop test
/// ends:
///
///   1. Associated law [ours]: the proximal interior point (proximal_interior_point.h) on the
///   convex
///      problem u_n = w + mu gamma (contact_jordan.h) down to a gap of 1 %. Its Newton matrix is
///      definite and its central path has no folds. At rest it has the solutions of the exact law.
///   2. Exact law, the same method from there: the dilatancy mu gamma goes over into w, which
///   leaves
///      the kinematic residual and all but the sliding contacts' products as they are.
///   3. Exact law from the central start, where 2 did not arrive (much sliding: impacts, flows).
///   4. Arclength continuation (arclength.h) along the folded central path of the better of 2
///   and 3.
/// After 2, 3 and 4 a good impulse is polished by proximal semismooth Newton (proximal_newton.h). A
/// failed round is followed by another from 0.1 and 10 times the start, then from random starts of
/// a fixed seed. Nothing guarantees an end at a solution: the status says stalled.
///
/// A start s0 is judged and, when its error is below 1e-2, handed to the polish; the interior point
/// itself starts cold. Contacts with mu = 0 have one pair only, no regularised friction.
/// Related: Acary, Armand, Nguyen and Shpakovych (2024) solve the associated cone program by an
/// interior point, Acary, Cadoux, Lemaréchal and Malick (2011) iterate on such programs.
SolveResult solve_interior_point(const ContactProblem& problem, const SolverOptions& options);

}  // namespace bipot
