#pragma once

#include "core/problem/contact_problem.h"

namespace bipot {

/// The criterion of data/manual/explanation/criterion.md in quadruple precision (113-bit significand), contact by
/// contact from its definition. It shares no code with core/criterion/contact_error.h nor with any
/// solver: an oracle for claims of convergence. Its rounding, 1e-18 of that in double precision, is no
/// part of any claim. Through the bodies where A is diagonal, else by W; NaN without either.
struct IndependentCheck {
  double epsilon = kNaN;
  double eta = kNaN;
  /// The larger one; NaN where either is, or where s has an entry that is not finite.
  double guarded = kNaN;
  Vector s;  ///< m, the impulse that is judged: each contact's nearest in the cone
  Vector u;  ///< m, its velocities, rounded to double

  /// Whether a claim "max(ε, η) <= tol" is true; there is no grace.
  bool confirms(double tol) const { return guarded <= tol; }
};

IndependentCheck independent_check(const ContactProblem& problem, const Vector& s);

}  // namespace bipot
