#pragma once

#include <string>
#include <vector>

#include "core/problem/contact_problem.h"

namespace bipot {

/// What a case says of a contact. In the plane a slipping contact has s on the edge of its cone that opposes u_t.
enum class CaseStatus {
  kAny,    ///< not distinguished: u_n >= 0, s in the cone
  kOpen,   ///< s = 0, u_n >= 0
  kStick,  ///< u = 0, s in the cone
  kLeft,   ///< u_n = 0, u_t <= 0, s = s_n (1, mu)
  kRight   ///< u_n = 0, u_t >= 0, s = s_n (1, -mu); without friction: u_n = 0, u_t free
};

/// A case, and the multipliers that exclude it: with y·u >= 0 for every u that the case allows (y_n >= 0 where u_n >= 0
/// only is known, y_t = 0 where nothing is known of u_t, of its sign where that is), but y·W s <= 0 for every s that it
/// allows and y·u_free < 0, no (s, u) with u = W s + u_free is left.
struct ExcludedCase {
  std::vector<CaseStatus> statuses;  ///< one a contact
  Vector multipliers;                ///< y, m
};

struct CaseExclusion {
  bool complete = false;  ///< every case is excluded
  double reach =
      kNaN;  ///< complete: no s with |s_n| sqrt(W_nn) up to this many times (Σ |u_free|²/W_nn)^½
  std::vector<ExcludedCase> cases;  ///< together all of them
  std::string message;              ///< why not complete
};

/// Excludes the 4^c cases of up to kMostContactsByCases contacts in d <= 2 one by one, whole branches of them at once where
/// contacts that are not distinguished yet leave nothing, by a linear programme (Farkas' lemma) each. What is found counts
/// only as far as reach_of_exclusion() confirms it. W need not be symmetric, nor semidefinite. `seconds`: wall-clock limit.
inline constexpr int kMostContactsByCases = 8;
CaseExclusion exclude_cases(const ContactProblem& problem, double seconds);

/// Checks one case in extended precision, from the problem's data as they stand and the multipliers alone: with g the rates
/// y·W e along the case's edges e (normal part 1), whose positive parts and rounding are bounded,
///
///     reach = -y·u_free / (Σ g⁺/sqrt(W_nn) · (Σ |u_free|²/W_nn)^½),
///
/// infinite where no rate is positive; every impulse of the case that solves the problem has a component beyond it. 0 where
/// the multipliers have a wrong sign or do not work against the data.
double reach_of_exclusion(const ContactProblem& problem, const ExcludedCase& excluded);

}  // namespace bipot
