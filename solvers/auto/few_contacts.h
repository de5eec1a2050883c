#pragma once

#include <span>

#include "core/problem/contact_problem.h"
#include "core/problem/delassus.h"

namespace bipot {

/// Solves islands of a few contacts of one problem without sparse matrices: one contact in closed
/// form (solve_local), several by block Gauss-Seidel sweeps, each block solved exactly, over a dense
/// W, until impulses no longer change in rounding.
class FewContacts {
 public:
  /// Keeps references to both.
  FewContacts(const ContactProblem& problem, const DelassusOperator& delassus);

  /// Writes the impulses of these contacts to their rows of s, starting from what stands there.
  /// Returns the sweeps (1 for a single contact), 0 where a block has no solution or the sweeps do
  /// not settle: s is unchanged then. Whether the result is good is the criterion's to say.
  int operator()(std::span<const int> contacts, Vector& s);

 private:
  template <int D>
  int single(int contact, Vector& s);
  template <int D>
  int sweeps(std::span<const int> contacts, Vector& s);
  double entry(int row, int column) const;

  const ContactProblem& problem_;
  const DelassusOperator& delassus_;
  Vector inverse_mass_;  // where W is not given
};

}  // namespace bipot
