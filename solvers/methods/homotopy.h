#pragma once

#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kHomotopyParameters[] = {
    ParameterSpec::number(
        "start_tol", "1e-3", {1e-8, 1},
        "error to which apgd prepares the start of the first path; 1: the start as it is"),
    ParameterSpec::number("delta", "3e-4", {1e-10, 1},
                          "proximal term of the first path, in units of the diagonal of W"),
    ParameterSpec::choice(
        "schedule", "bold", "bold|cautious|steady",
        "of the first chain of starts: bold shrinks delta at every path that arrives, cautious "
        "not soon again past one that failed, steady by the root of the factor; the latter two "
        "have shorter paths. Chains take them in turns"),
    ParameterSpec::choice(
        "shake", "after", "after|first",
        "chains from the best impulse with every component changed by up to a tenth, at random: "
        "after each of the others, or before them"),
    ParameterSpec::integer("seed", "1", {0, 2147483647}, "of the random changes of starts"),
};

/// Exact path following on Coulomb's law as a piecewise linear manifold (homotopy/law_cells.h),
/// d <= 2. From a point next to an impulse s0 the path of a proximal problem
/// (homotopy/path_follower.h) is followed by pivots, as Lemke's algorithm does (Lemke 1965; Eaves
/// 1976 for piecewise linear equations in general). Its proximal term is delta times diag W by the
/// load of each contact (homotopy/proximal_term.h). At the end the proximal problem is solved
/// exactly; its impulse is the anchor of the next one, with a smaller delta. The fixed points solve
/// the problem itself to rounding, for any delta: the linear systems are refined by residuals in 80
/// bits.
///
/// [ours] The cells are used directly instead of a complementarity problem with four rows for each
/// contact. The start is arbitrary, prepared by apgd. Its orientation follows from the sign of a
/// determinant, which tells the component that leads to a solution. Proximal stages start with a
/// large delta, since at small delta the path of an arbitrary start is often closed. After a failed
/// path, its turning point nearest to t = 1 is the next anchor, with a larger delta. That point is
/// judged too: its error is mostly below that of the path's start.
///
/// W may be singular. An iteration is a step of apgd, a pivot, or an impulse judged at a path's end
/// or turning point. Deterministic: `seed` fixes the perturbations of the starts. If paths keep
/// failing, apgd improves the best impulse so far to a better start; then another chain begins with
/// the first start again, less or better prepared, or with another schedule of delta. After the
/// last chain the solver ends with kStalled.
void solve_homotopy(SolveRun& run);

}  // namespace bipot
