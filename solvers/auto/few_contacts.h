#pragma once

#include <span>

#include "core/problem/contact_problem.h"
#include "core/problem/delassus.h"

namespace bipot {

/// Solves islands of a few contacts without sparse matrices: one contact in closed form
/// (solve_local), several by block Gauss-Seidel sweeps over a dense W, each block solved exactly,
/// until impulses no longer change in rounding.
class FewContacts {
 public:
  /// Keeps references to both.
  FewContacts(const ContactProblem& problem, const DelassusOperator& delassus);

  /// Writes the impulses of these contacts to their rows of s, starting from the present values.
  /// Returns the number of sweeps (1 for a single contact). Returns 0, s unchanged, if a block has
  /// no solution or the sweeps do not converge. The criterion judges the result.
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
