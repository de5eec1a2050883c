#pragma once

#include <vector>

#include "core/problem/contact_problem.h"

namespace bipot {

/// The problems as one, without coupling between them. All of one contact dimension and form (W
/// alone, or A and H, with W where all have it), row_scale in all or none. Contacts are dealt out
/// in turn (the first of each problem, the second of each, ...), degrees of freedom stand problem
/// by problem. `place[k][c]` is the contact of the whole that was contact c of problem k.
struct SideBySide {
  ContactProblem problem;
  std::vector<std::vector<int>> place;
};
SideBySide side_by_side(const std::vector<ContactProblem>& parts);

}  // namespace bipot
