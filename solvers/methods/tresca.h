#pragma once

#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kTrescaParameters[] = {
    ParameterSpec::number(
        "bound_accuracy", "0.1", {1e-6, 1},
        "of the problem with held bounds, as a part of the error of Coulomb's law"),
};

/// Fixed point on the bounds of friction (Haslinger 1983; Licht, Pratt and Raous 1991): friction
/// with given bounds g, Tresca's law,
///
///     0 <= s_n ⟂ u_n >= 0,     |s_t| <= g,   u_t opposes s_t where |s_t| = g,
///
/// minimises the convex ½ s·W s + u_free·s over half-lines and disks. Then g <- mu s_n. Its fixed
/// points solve Coulomb's law. Chen, Ly and Wojtan (SIGGRAPH 2024) and the option `signorini` of
/// Genesis lag the bounds in this way.
///
/// The problem with held bounds is solved by the accelerated projected gradient of `apgd`, with a
/// disk of fixed radius in place of the one that follows s_n, until its natural map is below
/// `bound_accuracy` times the error of Coulomb's law, or a tenth of the tolerance.
/// An iteration is a step of the gradient.
///
/// Limits: the inner problem is solved for any W. The bounds converge for small friction, and may
/// cycle for large: the solve then ends as stalled.
void solve_tresca(SolveRun& run);

}  // namespace bipot
