#pragma once

#include <span>
#include <vector>

#include "core/problem/contact_problem.h"

namespace bipot {

/// The contacts of a problem, part by part; parts do not couple: W has no block between them that
/// an impulse of the law could feel.
struct ContactIslands {
  std::vector<int> contacts;  ///< all of them, island after island, ascending within each
  std::vector<int> start;     ///< where each island begins, and the end

  int count() const { return static_cast<int>(start.size()) - 1; }
  std::span<const int> of(int island) const {
    return {contacts.data() + start[static_cast<std::size_t>(island)],
            contacts.data() + start[static_cast<std::size_t>(island) + 1]};
  }
};

/// Splits the contact graph into its connected components, smaller ones first, equal ones by their
/// first contact. Two contacts are connected where entries of H that are not 0 stand in the same
/// degree of freedom, or in two that A couples; without H, where W has an entry between them that is
/// not 0. Fixed bodies have no degree of freedom and connect nothing; a driven wall has one. The
/// tangential rows of a contact without friction connect nothing: no impulse ever stands there.
/// One pass over the entries.
ContactIslands contact_islands(const ContactProblem& problem);

}  // namespace bipot
