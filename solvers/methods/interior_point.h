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
    {.name = "relaxation",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "on",
     .choices = "on|off",
     .help = "solve the associated (convex) law roughly first, then drop its dilatancy"},
    {.name = "arclength",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "on",
     .choices = "on|off",
     .help = "follow the central path through its folds where the first stage stops"},
    {.name = "polish",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "on",
     .choices = "on|off",
     .help = "proximal semismooth Newton from the best impulse, last stage"},
    {.name = "stage_iterations",
     .kind = ParameterSpec::Kind::kInteger,
     .default_value = "150",
     .minimum = 1,
     .maximum = 100000,
     .help = "cap of the proximal interior point stage",
     .unit = "iterations"},
    {.name = "arc_iterations",
     .kind = ParameterSpec::Kind::kInteger,
     .default_value = "300",
     .minimum = 1,
     .maximum = 100000,
     .help = "cap of each arclength stage",
     .unit = "iterations"},
    {.name = "rounds",
     .kind = ParameterSpec::Kind::kInteger,
     .default_value = "20",
     .minimum = 1,
     .maximum = 1000,
     .help = "rounds of all stages, each from another start, before giving up",
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
