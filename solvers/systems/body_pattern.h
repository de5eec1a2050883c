#pragma once

#include <vector>

#include "core/base/lists.h"
#include "core/linear/frontal_tree.h"
#include "core/problem/contact_problem.h"

namespace bipot {

/// The contacts that act on each degree of freedom, ascending.
Lists<> contacts_of_dofs(const ContactProblem& problem);

/// The pattern of A + H R Hᵀ with its diagonal, for R with one d x d block for each contact. Row
/// and column i are dofs[i]. `dofs` is ascending and includes all dofs that contacts act on.
/// Couplings of A with other dofs are left out.
struct BodyPattern {
  std::vector<int> start, row;

  /// `contacts`: contacts_of_dofs().
  BodyPattern(const ContactProblem& problem, const Lists<>& contacts, const std::vector<int>& dofs);
  operator SymmetricPattern() const {  // NOLINT(google-explicit-constructor)
    return {static_cast<int>(start.size()) - 1, start.data(), row.data()};
  }
};

}  // namespace bipot
