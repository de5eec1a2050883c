#pragma once

#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kUzawaParameters[] = {
    {.name = "rho",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "stable",
     .choices = "stable|paper|adaptive",
     .help = "predictor step: a bound that converges, the paper's (1+e_n) m_i m_j/(m_i+m_j), "
             "or self-adaptive"},
    {.name = "refresh",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "jacobi",
     .choices = "jacobi|gauss-seidel",
     .help = "velocities are refreshed after all contacts, or after each"},
};

/// The paper's solver: bi-potential Uzawa (32)/(37)/(41), one predictor-corrector per contact,
///
///     tau = s - rho (u + mu |u_t| n),   s <- proj(tau, K_mu).
///
/// rho = paper and rho = stable: see predictor_steps.h.
///
/// rho = adaptive [ours, in equilibrated variables], with F(s) = û and the ratio
/// r = rho ‖F(s) - F(p)‖ / ‖s - p‖ of a prediction p = proj(s - rho F(s)): rho shrinks by
/// 2/3 min(1, 1/r) and p is drawn again while r > 0.9, and grows by 1.5 after a step with r < 0.4.
///   - jacobi: one rho for all, and the correction of He and Liao (J. Optim. Theory Appl. 112,
///     2002; the step rule goes back to Khobotov 1987):
///         s <- proj(s - 1.9 a rho F(p)),   a = (s - p)·d / ‖d‖²,   d = (s - p) - rho (F(s) - F(p)).
///     Two products with W an iteration. Converges for monotone F, that is for mu = 0 and for a
///     frozen de Saxcé term.
///   - gauss-seidel: one rho per contact, ratios from the contact's own velocity, s <- p.
///
/// The paper does not say when velocities are refreshed; both orders are offered. Impulses replace
/// the paper's forces (s = h r), which removes 1/h from rho.
///
/// In parallel, refresh = jacobi: the iterates of one process up to the bound of W's norm, which may be
/// larger where driven walls take part. An iteration is one exchange.
void solve_uzawa(SolveRun& run);

}  // namespace bipot
