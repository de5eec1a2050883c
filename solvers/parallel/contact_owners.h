#pragma once

#include <vector>

#include "core/problem/contact_problem.h"
#include "solvers/parallel/body_nodes.h"

namespace bipot {

/// The process that owns each contact.
struct ContactOwners {
  int processes = 1;
  std::vector<int> owner;        ///< rank, of each contact
  std::vector<double> contacts;  ///< of each process: how many it owns
};

/// Bodies belong to the cells of a CellTree with their numbers of contacts as weights, a contact to
/// the owner of its first body. Contacts without a body of their own are distributed by number.
/// `contact_places`: empty if unknown.
ContactOwners contact_owners(const ContactProblem& problem, const BodyNodes& nodes,
                             const std::vector<Vec3>& contact_places, int processes);

/// The same from an owner for each node.
ContactOwners contact_owners(const BodyNodes& nodes, const std::vector<int>& node_owner,
                             int processes);

}  // namespace bipot
