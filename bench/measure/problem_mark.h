#pragma once

#include <string>

#include "core/problem/contact_problem.h"

namespace bipot {

/// Figures by which two problems of one name are told apart.
struct ProblemMark {
  double velocity = kNaN;  ///< norm of u_free                       [m/s]
  double friction = kNaN;  ///< sum of all its coefficients
  double mobility = kNaN;  ///< trace of W                           [1/kg]

  /// Up to rounding; an unknown one fits all.
  bool fits(const ProblemMark& other) const;
};

ProblemMark mark_of(const ContactProblem& problem);
/// "|u_free| 1.2, friction 3, trace of W 4".
std::string to_string(const ProblemMark& mark);

}  // namespace bipot
