#pragma once

#include <optional>
#include <vector>

#include "core/problem/contact_problem.h"

namespace bipot {

/// The bodies of a problem, as far as they matter for who does what.
struct BodyNodes {
  std::vector<int> node;  ///< of each degree of freedom; -1: on every process
  int nodes = 0;
  std::vector<int> first;        ///< the smallest node of each contact; -1: none
  std::vector<double> contacts;  ///< of each node: how many contacts have it first
  std::vector<int> everywhere;   ///< degrees of freedom that every process has, ascending
};

/// A node is a rigid body where the rows of H show which they are (core/problem/body_rows.h), else
/// a single degree of freedom. Driven walls stand on every process, and so does whatever has more
/// than kManyContacts contacts: to copy all impulses on them would cost more than one sum.
/// Needs A and H, A diagonal.
BodyNodes body_nodes(const ContactProblem& problem);

inline constexpr int kManyContacts = 128;

/// Where the nodes are: the mean of their contacts' places, one a contact. Without places, a
/// node's number in a breadth-first walk from one end of the contact graph: neighbours stay near
/// each other, and cuts are lines of a constant number of steps. Nodes without contacts are at 0.
std::vector<Vec3> node_places(const ContactProblem& problem, const BodyNodes& nodes,
                              const std::vector<Vec3>& contact_places);

}  // namespace bipot
