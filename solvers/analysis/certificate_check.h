#pragma once

#include "core/problem/contact_problem.h"

namespace bipot {

/// Checks of certificates in extended precision (64-bit significand), from the data of the problem
/// and the certificate alone. They share no code with the search.

/// Margin by which the motion `y` and the share `weight` >= 0 of the data open all contacts. With B
/// = Hᵀ (or W if H is not given), u = B y + weight u_free and a_c = u_n - mu |u_t| (and less the
/// like of rolling),
///
///     margin = min over contacts of (a_c - r_c) / t_c.
///
/// t_c is the sum of the absolute values of all terms of a_c, and r_c bounds the rounding of its
/// evaluation. Positive: u lies inside K_mu* at every contact. This remains true for any relative
/// change of the entries of B and of u_free below the margin. -1 at worst. [-]
double opening_margin(const ContactProblem& problem, const Vector& y, double weight);

/// Result of checking a normal self-stress r_n >= 0 against the data.
struct Obstruction {
  /// -(r_n·w_n) / Σ r_n |w_n|, less the rounding: the relative change of w_n that would remove the
  /// obstruction. Not positive: there is none. [-]
  double strength = 0;
  /// Least speed of a motion that remains possible because H_n r_n vanishes only up to rounding.
  /// Relative to the data: |v| or |s| against Σ |u_free,c| in energy. Infinite if H_n r_n is 0. [-]
  double speed = 0;
};

/// `stress`: one entry >= 0 for each contact.
Obstruction obstruction(const ContactProblem& problem, const Vector& stress);

}  // namespace bipot
