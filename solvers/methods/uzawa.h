#pragma once

#include "solvers/solver.h"

namespace bipot {

/// Of `uzawa` and `classical`.
inline constexpr ParameterSpec kUzawaParameters[] = {
    ParameterSpec::choice(
        "rho", "stable", "stable|paper",
        "predictor step: a bound that converges, or the paper's (1+e_n) m_i m_j/(m_i+m_j)"),
    ParameterSpec::choice("refresh", "jacobi", "jacobi|gauss-seidel",
                          "velocities are refreshed after all contacts, or after each"),
};

/// The paper's solver: bi-potential Uzawa (32)/(37)/(41), one predictor-corrector per contact,
///
///     tau = s - rho (u + mu |u_t| n),   s <- proj(tau, K_mu).
///
/// rho = paper and rho = stable: see uzawa.cc.
///
/// The paper does not say when velocities are refreshed; both orders are offered. Impulses replace
/// the paper's forces (s = h r), which removes 1/h from rho.
///
/// In parallel (`classical` as well), refresh = jacobi: the iterates of one process up to the bound
/// of W's norm, which may be larger where driven walls take part. An iteration is one exchange.
void solve_uzawa(SolveRun& run);

/// The classical treatment, with which the paper compares its own (its references [2] and [15]). It
/// has two predictor-correctors for each contact, first the unilateral part, then friction with the
/// new s_n,
///
///     s_n <- max(0, s_n - rho u_n),      s_t <- s_t - rho u_t cut off at mu s_n,
///
/// in place of the single one of the bi-potential method. Both parts use the same velocities.
/// All else is as in uzawa. The stop test of the classical method in the paper is the relative
/// change of s between iterations: SolverOptions::stop = kImpulse.
void solve_classical(SolveRun& run);

/// Jacobi's order runs on all processes.
Parallel jacobi_in_parallel(const Parameters& parameters);

}  // namespace bipot
