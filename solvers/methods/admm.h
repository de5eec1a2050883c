#pragma once

#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kAdmmParameters[] = {
    ParameterSpec::number("rho", "0.001", {1e-9, 1e9},
                          "first penalty, in units of the diagonal of W", "W_ii"),
};

/// Alternating direction method of multipliers (Boyd, Parikh, Chu, Peleato and Eckstein, Found.
/// Trends Mach. Learn. 3, 2011) on the contact problem, for friction by Acary, Bremond and Huber
/// (2018) and Tasora, Mangoni, Benatti and Garziera (Int. J. Numer. Methods Eng. 122, 2021). In
/// variables x with a unit diagonal of W, z in the cone, y the scaled multiplier:
///
///     (W + rho I) x = rho (z - y) - b - mu |w_t| n
///     z⁺ = proj(x' + y, K_mu),    y⁺ = y + x' - z⁺,    x' = 1.6 x - 0.6 z
///
/// -rho y tends to de Saxcé's velocity, so that |w_t| = rho |y_t| is updated in every iteration;
/// for mu = 0, or |w_t| frozen, the method converges for every rho > 0.
///
/// The matrix of the linear system is factored once for each change of the penalties, by Cholesky's
/// method in single precision (frontal_cholesky.h): where A and H are given A + H M⁻¹ Hᵀ, for the
/// velocities (Woodbury), M = rho I or the penalties of the contacts, otherwise W + M. [ours] Each
/// iteration corrects the last x by its residual in double precision. What single precision leaves
/// vanishes with the change of x, as the iteration converges. For an unsymmetric W the symmetric
/// part is factored, and there are two corrections. Where the matrix is not positive definite in
/// single precision (rounded data, very small penalties) the penalties are raised tenfold.
///
/// The penalties. A small rho is quick on packings whose forces reach everywhere, a large one where
/// contacts slip and open. [ours] Each contact has a metric by what it does
/// (kernels/contact_penalties.h). While the best error does not halve, all are raised in steps, at
/// last to 300 times rho. Where that does not help either, they become one rho, which is then
/// balanced: when the primal residual ‖x - z‖ / max(‖x‖, ‖z‖) and the dual residual ‖z⁺ - z‖ / ‖y‖
/// differ by a factor above 25, rho is multiplied by the root of their ratio (relative residuals:
/// Wohlberg 2017; the rule of OSQP). One iteration is one linear solve.
void solve_admm(SolveRun& run);

}  // namespace bipot
