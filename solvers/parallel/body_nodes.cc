#include "solvers/parallel/body_nodes.h"

#include <algorithm>
#include <numeric>

#include "core/base/lists.h"
#include "core/problem/body_rows.h"

namespace bipot {
namespace {

/// Calls visit(node) for the nodes of a contact, each once, in any order.
template <class Visit>
void for_each_node(const ContactProblem& p, const BodyNodes& nodes, int contact, Visit visit) {
  int seen[8], count = 0;
  for (int k = 0; k < p.dim; ++k) {
    for (SparseMatrix::InnerIterator it(p.H, contact * p.dim + k); it; ++it) {
      const int node = nodes.node[to_size(it.row())];
      if (node < 0 || std::find(seen, seen + count, node) != seen + count) continue;
      if (count < 8) seen[count++] = node;
      visit(node);
    }
  }
}

/// Nodes along the contact graph: a first breadth-first search finds an end of each part, a second
/// one starts there.
std::vector<int> walk_from_the_ends(const ContactProblem& p, const BodyNodes& nodes) {
  const Lists<> contacts = make_lists(nodes.nodes, [&](const auto& put) {
    for (int c = 0; c < p.num_contacts(); ++c) {
      for_each_node(p, nodes, c, [&](int node) { put(node, c); });
    }
  });
  std::vector<int> visited(to_size(nodes.nodes), 0), part, order;
  // Appends the part of the graph around `start`; visited[node] becomes `mark`.
  const auto walk = [&](int start, int mark, std::vector<int>& walked) {
    std::size_t next = walked.size();
    const auto visit = [&](int node) {
      if (visited[to_size(node)] == mark) return;
      visited[to_size(node)] = mark;
      walked.push_back(node);
    };
    for (visit(start); next < walked.size(); ++next) {
      for (const int c : contacts.of(walked[next])) for_each_node(p, nodes, c, visit);
    }
  };
  for (int node = 0; node < nodes.nodes; ++node) {
    if (visited[to_size(node)] != 0) continue;
    part.clear();
    walk(node, 1, part);
    walk(part.back(), 2, order);
  }
  return order;
}

}  // namespace

BodyNodes body_nodes(const ContactProblem& p) {
  BodyNodes nodes;
  nodes.node.assign(to_size(p.num_dofs()), -1);
  if (const auto rows = find_body_rows(p)) {
    nodes.nodes = rows->bodies;
    for (int k = 0; k < rows->bodies * rows->per_body; ++k) {
      nodes.node[to_size(k)] = k / rows->per_body;
    }
  } else {
    nodes.nodes = p.num_dofs();
    std::iota(nodes.node.begin(), nodes.node.end(), 0);
  }
  std::vector<int> count(to_size(nodes.nodes), 0);
  for (int c = 0; c < p.num_contacts(); ++c) {
    for_each_node(p, nodes, c, [&](int node) { ++count[to_size(node)]; });
  }
  for (int& node : nodes.node) {
    if (node >= 0 && count[to_size(node)] > kManyContacts) node = -1;
  }
  for (int k = 0; k < p.num_dofs(); ++k) {
    if (nodes.node[to_size(k)] < 0) nodes.everywhere.push_back(k);
  }
  nodes.contacts.assign(to_size(nodes.nodes), 0);
  nodes.first.assign(to_size(p.num_contacts()), -1);
  for (int c = 0; c < p.num_contacts(); ++c) {
    int& first = nodes.first[to_size(c)];
    for_each_node(p, nodes, c, [&](int node) { first = first < 0 ? node : std::min(first, node); });
    if (first >= 0) ++nodes.contacts[to_size(first)];
  }
  return nodes;
}

std::vector<Vec3> node_places(const ContactProblem& p, const BodyNodes& nodes,
                              const std::vector<Vec3>& contact_places) {
  std::vector<Vec3> places(to_size(nodes.nodes), Vec3::Zero());
  if (contact_places.empty()) {
    const std::vector<int> order = walk_from_the_ends(p, nodes);
    for (std::size_t k = 0; k < order.size(); ++k) {
      places[to_size(order[k])][0] = static_cast<double>(k);
    }
    return places;
  }
  std::vector<int> count(to_size(nodes.nodes), 0);
  for (int c = 0; c < p.num_contacts(); ++c) {
    for_each_node(p, nodes, c, [&](int node) {
      places[to_size(node)] += contact_places[to_size(c)];
      ++count[to_size(node)];
    });
  }
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (count[k] > 0) places[k] /= count[k];
  }
  return places;
}

}  // namespace bipot
