#pragma once

#include "solvers/solve_run.h"

namespace bipot {

/// `ptc`: pseudo-transient continuation (Kelley and Keyes 1998) of the equation of Alart and Curnier
/// (1991), see proximal_newton(). An iteration is one factorisation. From s = 0 on large problems it
/// may wander; from an error of 1e-2 or less it needs some 20 to 150 iterations to 1e-8.
/// kStalled: no pseudo-time step reduces the equation, or rounding forbids more.
void solve_pseudo_transient(SolveRun& run);

}  // namespace bipot
