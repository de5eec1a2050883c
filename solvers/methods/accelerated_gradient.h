#pragma once

#include "solvers/solver.h"

namespace bipot {

inline constexpr ParameterSpec kAcceleratedGradientParameters[] = {
    ParameterSpec::choice(
        "map", "auto", "auto|split|followed",
        "normal part first, then the friction disk; or projection on the cone with de Saxce's "
        "term held and followed; auto: split, and followed once it stagnates"),
    ParameterSpec::integer("hold", "16", {1, 100000},
                           "of map = followed: iterations between two steps of de Saxce's term",
                           "iterations"),
    ParameterSpec::number("step", "1", {1e-3, 2}, "step in multiples of 1/lambda_max",
                          "1/lambda_max"),
};

/// Nesterov's accelerated projected gradient with adaptive restart, for contact by Mazhar, Heyn,
/// Negrut and Tasora (ACM Trans. Graph. 34, 2015). In variables x with a unit diagonal of W
/// (contact_scaling.h), L an estimate of lambda_max and w = W x + b,
///
///     y = x + beta (x - x⁻),          x⁺ = P(y - w(y)/L),
///     t⁺ = (1 + sqrt(1 + 4 t²))/2,    beta = (t - 1)/t⁺
///
/// with t = 1 again whenever (y - x⁺)·(x⁺ - x) > 0 (gradient restart of O'Donoghue and Candes,
/// Found. Comput. Math. 15, 2015). P is either
///   - split: x_n = max(0, tau_n), then x_t = tau_t cut off at mu x_n (Alart and Curnier 1991), or
///   - followed: proj(y - (w + sigma n)/L, K_mu). Here sigma holds de Saxcé's term mu |w_t| from an
///     earlier iterate: every `hold` iterations sigma <- sigma + kappa (mu |w_t| - sigma), kappa
///     = min(1, 1600/k) after k iterations. It begins with mu |w_t| of a start that is not 0, else
///     with 0.
/// The fixed points of both are exactly the solutions of Coulomb's law. [ours] `followed` is
/// explained in data/manual/explanation/method.md §5: sigma follows the map of Brouwer's theorem of
/// §6, with the damping of Krasnoselskii and Mann. Split cycles where bodies slide, but needs fewer
/// iterations on lattices and piles. [ours] auto starts with split. If it stagnates (at least 1000
/// iterations), followed continues from the best iterate.
///
/// L: 30 steps of the power method, with a margin of 5 %. Each step measures the curvature (x -
/// x⁻)·W(x - x⁻)/‖x - x⁻‖². If it exceeds L, L is raised and momentum dropped.
///
/// Limits: for mu = 0 this is FISTA on a convex quadratic, error O(1/k²); with friction convergence
/// is not proved. An unsymmetric W (rounded data) is used as it is.
///
/// Deviations from the source: equilibrated variables, split map, no line search on the objective
/// (with friction there is none), velocities at y from those at x and x⁻. Disks and spheres run in
/// vectors and on threads (solvers/disks/tiled_gradient.h), with the same bits for any number of
/// them.
///
/// In parallel the iterates are those of one process up to the order of the sums. An iteration is
/// one exchange and one reduction of three numbers.
void solve_accelerated_gradient(SolveRun& run);

}  // namespace bipot
