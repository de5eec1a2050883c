#pragma once

#include <vector>

#include "core/problem/contact_problem.h"

namespace bipot {

/// The bodies of a problem, as far as the partition needs them.
struct BodyNodes {
  std::vector<int> node;  ///< of each degree of freedom; -1: on every process
  int nodes = 0;
  std::vector<int> first;        ///< the smallest node of each contact; -1: none
  std::vector<double> contacts;  ///< of each node: number of contacts whose first body it is
  std::vector<int> everywhere;   ///< degrees of freedom that every process has, ascending
};

/// A node is a rigid body if the rows of H show these (core/problem/body_rows.h), else a single
/// degree of freedom. Driven walls are on every process. So is every body with more than
/// kManyContacts contacts: copies of all impulses on it would cost more than one sum. Needs A and
/// H, A diagonal.
BodyNodes body_nodes(const ContactProblem& problem);

inline constexpr int kManyContacts = 128;

/// Positions of the nodes: the mean over their contacts' positions. Without positions, a node's
/// number in a breadth-first search from one end of the contact graph: neighbours stay near each
/// other, and cuts are lines of a constant number of steps. Nodes without contacts are at 0.
std::vector<Vec3> node_places(const ContactProblem& problem, const BodyNodes& nodes,
                              const std::vector<Vec3>& contact_places);

}  // namespace bipot
