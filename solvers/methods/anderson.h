#pragma once

#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kAndersonParameters[] = {
    ParameterSpec::integer("memory", "8", {1, 100}, "number of earlier iterates that are combined",
                           "iterates"),
    ParameterSpec::choice(
        "map", "sweep", "sweep|gradient",
        "accelerated map: a symmetric Gauss-Seidel sweep, or one projected gradient step"),
};

/// Anderson acceleration of a fixed-point map G in variables with a unit diagonal of W. With
/// f = G(x) - x, ΔF and ΔG the differences of the last `memory` values,
///
///     x <- G(x) - ΔG gamma,     gamma = argmin ‖f - ΔF gamma‖
///
/// (Walker and Ni, SIAM J. Numer. Anal. 49, 2011). The least squares are solved by normal equations
/// and a Cholesky factor of columns of length 1, newest first (kernels/anderson_iteration.h). The
/// first column with a pivot below 1e-10 is dropped with all older ones. G is a forward and a
/// backward sweep of pgs with local steps, or one step of the split map of apgd with step
/// 1/lambda_max.
///
/// Safeguard in the manner of Zhang, O'Donoghue and Boyd (SIAM J. Optim. 30, 2020): an accelerated
/// point is accepted while its residual ‖f‖ is at most twice the smallest since the last restart
/// (theirs accepts by a bound that falls with the number of accepted points); otherwise the plain
/// G(x) of the last accepted point is taken and the memory is cleared. Every evaluation of G counts
/// as one iteration, rejected ones too. With friction there is no proof of convergence.
void solve_anderson(SolveRun& run);
Parallel anderson_in_parallel(const Parameters& parameters);

}  // namespace bipot
