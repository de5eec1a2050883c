#pragma once

#include <span>
#include <vector>

#include "core/problem/contact_problem.h"

namespace bipot {

/// The first `dim` rows of each of these contacts, in a problem with `whole_dim` rows for each.
std::vector<int> rows_of_contacts(std::span<const int> contacts, int whole_dim, int dim);

/// The problem of these contacts, with these rows, in the degrees of freedom `dofs`; both ascend.
/// `number`: the place of each degree of freedom in `dofs`, negative for others, whose entries are
/// left out. So is W.
ContactProblem cut_problem(const ContactProblem& whole, std::span<const int> contacts, int dim,
                           std::span<const int> dofs, const std::vector<int>& number);

}  // namespace bipot
