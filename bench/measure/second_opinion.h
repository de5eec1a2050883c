#pragma once

#include "core/problem/contact_problem.h"

namespace bipot {

/// Independent check of the criterion of data/manual/explanation/criterion.md in quadruple
/// precision (113-bit significand), contact by contact from its definition. It shares no code with
/// core/criterion/contact_error.h nor with any solver: an oracle for claims of convergence. Its
/// rounding is negligible, 1e-18 of that in double precision. It works through the bodies if A is
/// diagonal, else by W; NaN without either.
struct SecondOpinion {
  double epsilon = kNaN;
  double eta = kNaN;
  /// The larger one; NaN if either is, or if s has an entry that is not finite.
  double guarded = kNaN;
  Vector s;  ///< m, the judged impulse: that of each contact moved to the nearest point of the cone
  Vector u;  ///< m, its velocities, rounded to double

  /// True if a claim "max(ε, η) <= tol" holds, without allowance.
  bool confirms(double tol) const { return guarded <= tol; }
};

SecondOpinion second_opinion(const ContactProblem& problem, const Vector& s);

}  // namespace bipot
