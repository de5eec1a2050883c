#pragma once

#include <functional>
#include <string>

#include "core/problem/contact_problem.h"

namespace bipot {

/// Proved statement on the existence of a solution (data/manual/explanation/method.md §6).
enum class Existence {
  kUndecided,     ///< neither was proved
  kExists,        ///< for these data, and all that differ by less than `margin`
  kExistsNearby,  ///< for data that differ from these by no more than `margin`: rounding
  /// No motion slower than 1/`margin` times the data obeys even the normal law. By cases: no
  /// impulses below this many times the data obey the law.
  kNone
};
std::string_view to_string(Existence verdict);

struct ExistenceCertificate {
  Existence verdict = Existence::kUndecided;
  double margin = kNaN;  ///< relative, see Existence                                         [-]
  std::string reason;    ///< one sentence
  Vector motion;         ///< kExists, kExistsNearby: y of certificate_check.h; n, or m rows of W
  double weight = 0;     ///< of the data in that motion
  Vector stress;         ///< kNone: the normal self-stress, one entry a contact
  int cases = 0;         ///< kNone by cases: number of excluded cases, see case_exclusion.h
  double seconds = 0;    ///< of the search
};

/// Seeks a proof by linear programmes of the size of the problem, in this order
/// (data/manual/explanation/method.md §6 has the proofs and the sources):
///
///   1. r ∈ K_mu, r ≠ 0, H r = 0, r·w <= 0: none, if a motion opens every contact;
///   2. r_n >= 0, H_n r_n = 0, r_n·w_n < 0: such a self-stress excludes every solution;
///   3. for d <= 2, r ∈ K_mu, H r = 0, r·w < 0: none, if a motion closes no contact, which is enough
///      there, but without margin: true for data within rounding of these;
///   4. for d <= 2 and few contacts, for any W: case_exclusion.h.
///
/// For d = 3, K_mu is widened to a cone with 16 edges, which narrows K_mu*: proofs remain valid.
/// Without A and H, H r = 0 reads W r = 0. A result counts only as far as certificate_check.h
/// confirms it. `seconds`: wall-clock limit of the search; `cancelled`: true ends it. The problem
/// must pass validate(). For an unsymmetric or indefinite W only 4 applies.
ExistenceCertificate certify_existence(const ContactProblem& problem, double seconds = kInfinity,
                                       const std::function<bool()>& cancelled = {});

/// As "a solution exists (proved, margin 2.1e-03)", "no solution exists (proved, …)", "undecided:
/// …".
std::string to_text(const ExistenceCertificate& certificate);

}  // namespace bipot
