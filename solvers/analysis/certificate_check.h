#pragma once

#include "core/problem/contact_problem.h"

namespace bipot {

/// Checks of certificates in extended precision (64-bit significand), from the problem's data as
/// they stand and the certificate alone. They share no code with the search.

/// How far the motion `y` and the share `weight` >= 0 of the data open all contacts: with
/// B = Hᵀ (or W where H is not given), u = B y + weight u_free and a_c = u_n - mu |u_t|,
///
///     margin = min over contacts of (a_c - r_c) / t_c,
///
/// where t_c is the sum of the absolute values of all terms of a_c and r_c bounds the rounding of
/// its evaluation. Positive: u lies inside K_mu* at every contact, and would for any change of the
/// entries of B and of u_free by less than this share of themselves. -1 at worst. [-]
double opening_margin(const ContactProblem& problem, const Vector& y, double weight);

/// What a normal self-stress r_n >= 0 says against the data.
struct Obstruction {
  /// -(r_n·w_n) / Σ r_n |w_n|, less the rounding: the relative change of w_n that would be needed
  /// to let it pass. Not positive: nothing is obstructed.                                      [-]
  double strength = 0;
  /// The motion that r_n leaves possible because H_n r_n vanishes up to rounding only: at least
  /// this many times as fast as the data, |v| or |s| against Σ |u_free,c| in energy. Infinite where
  /// H_n r_n is 0.                                                                            [-]
  double speed = 0;
};

/// `stress`: one entry a contact, >= 0.
Obstruction obstruction(const ContactProblem& problem, const Vector& stress);

}  // namespace bipot
