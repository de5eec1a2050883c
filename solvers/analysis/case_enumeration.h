#pragma once

#include <functional>
#include <vector>

#include "core/problem/contact_problem.h"

namespace bipot {

/// Most cases that are looked at: 7 contacts with friction in the plane.
inline constexpr int kMostCases = 20000;

/// All exact answers of a problem of few contacts for d <= 2: every contact is open (s = 0), sticks
/// (u = 0), or slips to either side (u_n = 0, s on that edge of the cone). Each case is a linear
/// system, whose solution is an answer if it obeys the inequalities of the law.
struct EnumeratedCases {
  int cases = 0;                   ///< looked at; 0: too many, or d = 3
  int undecided = 0;               ///< singular, consistent, and the tried solution is no answer
  int continua = 0;                ///< singular, with an answer: others lie beside it
  std::vector<Vector> candidates;  ///< impulses that obey the inequalities to rounding   [N s]
};
/// `stopped`: true ends the search; then cases is 0.
EnumeratedCases enumerate_cases(const ContactProblem& problem,
                                const std::function<bool()>& stopped);

}  // namespace bipot
