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
/// rho = paper and rho = stable: see predictor_steps.h.
///
/// The paper does not say when velocities are refreshed; both orders are offered. Impulses replace
/// the paper's forces (s = h r), which removes 1/h from rho.
///
/// In parallel, refresh = jacobi: the iterates of one process up to the bound of W's norm, which
/// may be larger where driven walls take part. An iteration is one exchange.
void solve_uzawa(SolveRun& run);

}  // namespace bipot
