#pragma once

#include "core/problem/contact_problem.h"

namespace bipot {

/// The criterion of data/criterion.md in extended precision (64-bit significand), contact by
/// contact from its definition. It shares no code with core/problem/contact_error.h nor with any
/// solver: an oracle for claims of convergence. A must be diagonal, or W given.
struct SecondOpinion {
  double epsilon = kNaN;
  double eta = kNaN;
  /// The larger one; NaN where either is, or where s has an entry that is not finite.
  double guarded = kNaN;
  Vector s;  ///< m, the impulse that is judged: each contact's nearest in the cone
  Vector u;  ///< m, its velocities, rounded to double
};
/// A claim holds where the second opinion finds at most this many tolerances.
inline constexpr double kGrace = 1.5;

SecondOpinion second_opinion(const ContactProblem& problem, const Vector& s);

}  // namespace bipot
