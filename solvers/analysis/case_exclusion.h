#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/problem/contact_problem.h"

namespace bipot {

struct CaseExclusion {
  /// Status of a contact in a case. In 2D a slipping contact has s on the edge of its cone that
  /// opposes u_t.
  enum class Status {
    kAny,    ///< not distinguished: u_n >= 0, s in the cone
    kOpen,   ///< s = 0, u_n >= 0
    kStick,  ///< u = 0, s in the cone
    kLeft,   ///< u_n = 0, u_t <= 0, s = s_n (1, mu)
    kRight   ///< u_n = 0, u_t >= 0, s = s_n (1, -mu); without friction: u_n = 0, u_t free
  };
  using enum Status;
  /// A case, and the multipliers y that exclude it. They satisfy y·u >= 0 for every u of the case:
  /// y_n >= 0 if only u_n >= 0 is known, y_t = 0 if u_t is unknown, the sign of u_t if that is
  /// known. They satisfy y·W s <= 0 for every s of the case, and y·u_free < 0. Hence no (s, u) with
  /// u = W s + u_free exists.
  struct Case {
    std::vector<Status> statuses;  ///< one a contact
    Vector multipliers;            ///< y, m
  };
  bool complete = false;  ///< every case is excluded
  double reach =
      kNaN;  ///< complete: no s with |s_n| sqrt(W_nn) up to this many times (Σ |u_free|²/W_nn)^½
  std::vector<Case> cases;  ///< together all of them
  std::string message;      ///< why not complete
};

/// Excludes the 4^c cases of up to kMostContactsByCases contacts for d <= 2, by a linear programme
/// (Farkas' lemma) each. Whole branches are excluded at once if contacts that are not yet
/// distinguished already leave no solution. A result counts only as far as reach_of_exclusion()
/// confirms it. W need be neither symmetric nor semidefinite. `stopped`: true ends it.
inline constexpr int kMostContactsByCases = 8;
CaseExclusion exclude_cases(const ContactProblem& problem, const std::function<bool()>& stopped);

/// Checks one case in extended precision, from the data of the problem and the multipliers alone.
/// With g the rates y·W e along the edges e of the case (normal part 1), whose positive parts and
/// rounding are bounded,
///
///     reach = -y·u_free / (Σ g⁺/sqrt(W_nn) · (Σ |u_free|²/W_nn)^½),
///
/// infinite if no rate is positive. Every impulse of the case that solves the problem has a
/// component beyond it. 0 if the multipliers have a wrong sign or do not exclude the data.
double reach_of_exclusion(const ContactProblem& problem, const CaseExclusion::Case& excluded);

}  // namespace bipot
