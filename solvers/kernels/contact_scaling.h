#pragma once

#include "core/problem/contact_problem.h"
#include "core/problem/coulomb_cone.h"

namespace bipot {

/// A change of variables x = impulse ∘ s, w = velocity ∘ u, with one positive factor for the normal
/// and one for all tangents of each contact, one for all rolling rows and one for the spin. Coulomb's law is homogeneous in either part, hence
/// keeps its form with the friction coefficient mu below (data/manual/explanation/method.md §3).
struct ContactScaling {
  Vector impulse;        ///< m, x = impulse ∘ s
  Vector velocity;       ///< m, w = velocity ∘ u
  Vector mu;             ///< c, mu_x = mu impulse_t / impulse_n
  Vector mu_r, mu_spin;  ///< likewise; empty without rolling friction
};

/// Diagonal of W, with the tangential entries of each contact replaced by their mean, size m; the
/// rolling ones likewise. A contact without tangential mobility (rounded data) uses its normal entry
/// instead. So does one without mobility in rolling, by a length (rolling_arms()).
Vector mean_diagonal(const ContactProblem& problem, const Vector& delassus_diagonal);

/// x = sqrt(W_ii) s, w = u / sqrt(W_ii), tangents averaged: the operator gets a unit diagonal.
ContactScaling equilibrated_scaling(const ContactProblem& problem, const Vector& delassus_diagonal);

/// x = s / r, w = u / r: the physical variables of the problem, rolling rows by rolling_arms().
ContactScaling physical_scaling(const ContactProblem& problem, const Vector& delassus_diagonal);

}  // namespace bipot
