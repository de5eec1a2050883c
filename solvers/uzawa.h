#pragma once

#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kUzawaParameters[] = {
    {.name = "rho",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "stable",
     .choices = "stable|paper",
     .help = "predictor step: a bound that converges, or the paper's (1+e_n) m_i m_j/(m_i+m_j)"},
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
/// rho = paper: rho = (1 + e_n) m_i m_j / (m_i + m_j) = 1/W_nn of the step's operator, in physical
/// variables, normal and tangential part alike. For a disk W_tt = 3 W_nn, so that a sticking
/// contact lies outside the stable range of a fixed step: this choice reproduces the paper and its
/// limits.
///
/// rho = stable [ours]: variables scaled so that W has a unit diagonal (one scale for all tangents
/// of a contact, mu changes by the ratio of the scales), then
///   - jacobi: rho = 1.9 / ‖W‖_inf <= 1.9 / lambda_max(W). For mu = 0 this is the projected
///   gradient
///     of a convex quadratic with a step below 2/lambda_max, which converges (Goldstein 1964,
///     Levitin and Polyak 1966). With friction the problem is not a minimisation and no step is
///     proved to converge.
///   - gauss-seidel: rho = 1. For mu = 0 each update minimises exactly along its coordinate, and
///     the cyclic sweep converges (Luo and Tseng 1992).
///
/// The paper does not say when velocities are refreshed; both orders are offered. Impulses replace
/// the paper's forces (s = h r), which removes 1/h from rho.
SolveResult solve_uzawa(const ContactProblem& problem, const SolverOptions& options);

}  // namespace bipot
