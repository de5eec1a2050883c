#pragma once

#include <vector>

#include "core/problem/contact_problem.h"
#include "solvers/parallel/body_nodes.h"

namespace bipot {

/// Which process has which contact.
struct ContactOwners {
  int processes = 1;
  std::vector<int> owner;        ///< rank, of each contact
  std::vector<double> contacts;  ///< of each process: how many it owns
};

/// Bodies belong to the cells of a CellTree with the contacts that they bring along as weights, and a
/// contact to the owner of its first body. Contacts without a body of their own are dealt out by
/// number. `contact_places`: empty where nobody knows them.
ContactOwners contact_owners(const ContactProblem& problem, const BodyNodes& nodes,
                             const std::vector<Vec3>& contact_places, int processes);

/// The same from an owner for each node.
ContactOwners contact_owners(const BodyNodes& nodes, const std::vector<int>& node_owner,
                             int processes);

}  // namespace bipot
