#include "solvers/parallel/body_nodes.h"

#include <algorithm>
#include <numeric>

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

/// Contacts of each node, as a graph in compressed rows.
struct NodeContacts {
  std::vector<int> start, contact;
};

NodeContacts contacts_of_nodes(const ContactProblem& p, const BodyNodes& nodes) {
  NodeContacts graph;
  graph.start.assign(to_size(nodes.nodes) + 1, 0);
  for (int c = 0; c < p.num_contacts(); ++c) {
    for_each_node(p, nodes, c, [&](int node) { ++graph.start[to_size(node) + 1]; });
  }
  std::partial_sum(graph.start.begin(), graph.start.end(), graph.start.begin());
  graph.contact.resize(to_size(graph.start.back()));
  std::vector<int> next(graph.start.begin(), graph.start.end() - 1);
  for (int c = 0; c < p.num_contacts(); ++c) {
    for_each_node(p, nodes, c,
                  [&](int node) { graph.contact[to_size(next[to_size(node)]++)] = c; });
  }
  return graph;
}

/// Nodes in the order of a breadth-first search that begins at `start`.
class BreadthFirst {
 public:
  BreadthFirst(const ContactProblem& p, const BodyNodes& nodes)
      : p_(p), nodes_(nodes), graph_(contacts_of_nodes(p, nodes)) {}

  /// Appends the part of the graph around `start`; visited[node] becomes `mark`.
  void walk(int start, int mark, std::vector<int>& visited, std::vector<int>& order) const {
    std::size_t next = order.size();
    order.push_back(start);
    visited[to_size(start)] = mark;
    for (; next < order.size(); ++next) {
      const int node = order[next];
      for (int k = graph_.start[to_size(node)]; k < graph_.start[to_size(node) + 1]; ++k) {
        for_each_node(p_, nodes_, graph_.contact[to_size(k)], [&](int other) {
          if (visited[to_size(other)] == mark) return;
          visited[to_size(other)] = mark;
          order.push_back(other);
        });
      }
    }
  }

 private:
  const ContactProblem& p_;
  const BodyNodes& nodes_;
  NodeContacts graph_;
};

/// The first search finds an end of each part, the second starts there.
std::vector<int> walk_from_the_ends(const ContactProblem& p, const BodyNodes& nodes) {
  const BreadthFirst graph(p, nodes);
  std::vector<int> visited(to_size(nodes.nodes), 0), part, order;
  for (int node = 0; node < nodes.nodes; ++node) {
    if (visited[to_size(node)] != 0) continue;
    part.clear();
    graph.walk(node, 1, visited, part);
    graph.walk(part.back(), 2, visited, order);
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
