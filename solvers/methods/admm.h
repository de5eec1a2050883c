#pragma once

#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kAdmmParameters[] = {
    {.name = "rho",
     .kind = ParameterSpec::Kind::kNumber,
     .default_value = "0.001",
     .minimum = 1e-9,
     .maximum = 1e9,
     .help = "first penalty, in units of the diagonal of W",
     .unit = "W_ii"},
    {.name = "relaxation",
     .kind = ParameterSpec::Kind::kNumber,
     .default_value = "1.6",
     .minimum = 0.1,
     .maximum = 1.95,
     .help = "over-relaxation"},
    {.name = "penalty",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "status",
     .choices = "status|staged|balanced|fixed",
     .help = "one a contact, by its status; the same for all: raised where the error stagnates and "
             "then balanced, residuals balanced, constant"},
    {.name = "precision",
     .kind = ParameterSpec::Kind::kChoice,
     .default_value = "auto",
     .choices = "auto|double|single",
     .help = "of the factor of a problem given by A and H; single: half its memory, and every "
             "solve corrects the one before; auto: single from 10000 contacts on"},
};

/// Alternating direction method of multipliers (Boyd, Parikh, Chu, Peleato and Eckstein, Found.
/// Trends Mach. Learn. 3, 2011) on the contact problem, for friction by Acary, Bremond and Huber
/// (2018) and Tasora, Mangoni, Benatti and Garziera (Int. J. Numer. Methods Eng. 122, 2021). In
/// variables x with a unit diagonal of W, z in the cone, y the scaled multiplier:
///
///     (W + rho I) x = rho (z - y) - b - mu |w_t| n
///     z⁺ = proj(x' + y, K_mu),    y⁺ = y + x' - z⁺,    x' = a x + (1 - a) z
///
/// -rho y tends to de Saxcé's velocity, so that |w_t| = rho |y_t| is updated in every iteration;
/// for mu = 0, or |w_t| frozen, the method converges for every rho > 0 and 0 < a < 2.
///
/// The linear system is solved with one sparse Cholesky factorisation (frontal_cholesky.h) per change of the
/// penalties: where A and H are given through A + H M⁻¹ Hᵀ in the velocities (Woodbury), M = rho I
/// or the penalties of the contacts, otherwise W + M itself. [ours] For an unsymmetric W the
/// symmetric part is factored and the rest is taken in by two steps of residual correction; where
/// W + M is not positive definite (rounded data) the penalties are raised tenfold. A factor kept in
/// single precision corrects the velocities of the iteration before by what is left of the right side:
/// fixed points are those of exact solves. [ours]
///
/// The penalties. A small rho is quick on packings whose forces reach everywhere, a large one where
/// contacts slip and open. [ours] status: both, as each contact has a metric by what it does
/// (kernels/contact_penalties.h), changed every 75 iterations; while the best error has not halved
/// for 70, all are raised by sqrt(10), up to 60 times rho, then up to 300 times rho at
/// intervals of 600; where that does not halve it for 2000, they are one rho, balanced as below. On
/// packings with 7000 to 18 000 contacts 1e-3 takes 561 to 844 iterations where one rho for all takes
/// 1829 to more than 8796 (data/manual/results/performance.md). staged: one rho, raised after 100 such
/// iterations, six times; after that, balanced: when the primal residual ‖x - z‖ / max(‖x‖, ‖z‖)
/// and the dual residual ‖z⁺ - z‖ / ‖y‖ differ by a factor above 25, rho is multiplied by the root
/// of their ratio (relative residuals: Wohlberg 2017; the rule of OSQP), at intervals that grow with
/// the iteration count. One iteration is one linear solve.
void solve_admm(SolveRun& run);

}  // namespace bipot
