#pragma once

#include "solvers/solver.h"

namespace bipot {

/// Another law, for contrast: the associated one, in which the velocity at a sliding contact is
/// normal to the cone,
///
///     K_mu* ∋ u  ⟂  s ∈ K_mu,      hence u_n = mu |u_t| where a contact slides: it opens.
///
/// It minimises the convex ½ s·W s + u_free·s over the cones (Anitescu, Math. Program. 105, 2006).
/// Chrono solves this complementarity problem (Mazhar et al. 2015), Drake one with a regularisation
/// (Castro, Permenter and Han 2022). Where all closed contacts stick it is Coulomb's law.
///
/// Solved by the accelerated projected gradient of `apgd` with map = followed and sigma = 0, which
/// converges like 1/k² in energy. Answers are judged by Coulomb's law like all others:
/// converged only where they obey it. Else, once the associated law holds to `tol` and the error of
/// Coulomb's law is a thousand times larger, the end is kStalled, and the message says how quickly
/// sliding contacts open.
void solve_convex(SolveRun& run);

}  // namespace bipot
