#pragma once

#include "core/problem/contact_problem.h"

namespace bipot {

/// Independent check of the criterion of data/manual/explanation/criterion.md in quadruple
/// precision (113-bit significand), contact by contact from its definition. On purpose it shares no
/// code with core/criterion nor with any solver, and repeats all formulas: it judges claims of
/// convergence. Its rounding is negligible, 1e-18 of that in double precision. It works through the
/// bodies if A is diagonal, else by W; NaN without either.
struct IndependentCheck {
  double epsilon = kNaN;
  double eta = kNaN;
  /// The larger one; NaN if either is, or if s has an entry that is not finite.
  double guarded = kNaN;
  Vector s;  ///< m, the judged impulse: that of each contact moved to the nearest point of the cone
  Vector u;  ///< m, its velocities, rounded to double

  /// True if a claim "max(ε, η) <= tol" holds, without allowance.
  bool confirms(double tol) const { return guarded <= tol; }
};

IndependentCheck independent_check(const ContactProblem& problem, const Vector& s);

}  // namespace bipot
