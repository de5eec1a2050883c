#pragma once

#include "solvers/solver.h"

namespace bipot {

/// The classical treatment, with which the paper compares its own (its references [2] and [15]). It
/// has two predictor-correctors for each contact, first the unilateral part, then friction with the
/// new s_n,
///
///     s_n <- max(0, s_n - rho u_n),      s_t <- s_t - rho u_t cut off at mu s_n,
///
/// in place of the single one of the bi-potential method. Both parts use the same velocities.
/// Variables and rho are those of uzawa (predictor_steps.h), so that only the corrector differs.
/// The stop test of the classical method in the paper is the relative change of s between
/// iterations: SolverOptions::stop = kImpulse. Impulses replace forces.
///
/// In parallel, refresh = jacobi: the iterates of one process up to the bound of W's norm, which
/// may be larger with driven walls. An iteration is one exchange.
void solve_classical(SolveRun& run);

}  // namespace bipot
