#include "solvers/auto/contact_islands.h"

#include <algorithm>

#include "core/base/disjoint_sets.h"

namespace bipot {
namespace {

/// Rows of a contact with possible impulses.
int live_rows(const ContactProblem& p, int contact) {
  return p.mu[contact] > 0 || p.rolls() ? p.dim : 1;
}

/// Contacts first, then degrees of freedom.
DisjointSets through_bodies(const ContactProblem& p) {
  const int contacts = p.num_contacts();
  DisjointSets sets(contacts + p.num_dofs());
  for (int c = 0; c < contacts; ++c) {
    for (int k = 0; k < live_rows(p, c); ++k) {
      for (SparseMatrix::InnerIterator it(p.H, c * p.dim + k); it; ++it) {
        if (it.value() != 0) sets.unite(c, contacts + static_cast<int>(it.row()));
      }
    }
  }
  for (int column = 0; column < p.A.outerSize(); ++column) {
    for (SparseMatrix::InnerIterator it(p.A, column); it; ++it) {
      if (it.row() != column && it.value() != 0) {
        sets.unite(contacts + column, contacts + static_cast<int>(it.row()));
      }
    }
  }
  return sets;
}

DisjointSets through_delassus(const ContactProblem& p) {
  DisjointSets sets(p.num_contacts());
  for (int c = 0; c < p.num_contacts(); ++c) {
    for (int k = 0; k < live_rows(p, c); ++k) {
      for (SparseRows::InnerIterator it(p.W, c * p.dim + k); it; ++it) {
        const int other = static_cast<int>(it.col()) / p.dim;
        const int row = static_cast<int>(it.col()) % p.dim;
        if (other != c && it.value() != 0 && row < live_rows(p, other)) sets.unite(c, other);
      }
    }
  }
  return sets;
}

}  // namespace

ContactIslands contact_islands(const ContactProblem& p) {
  const int contacts = p.num_contacts();
  if (contacts == 0) return {};
  DisjointSets sets = p.has_velocities() ? through_bodies(p) : through_delassus(p);
  // A set is known by its smallest member, which is a contact: numbers follow first contacts.
  std::vector<int> number(to_size(contacts), -1), island_of(to_size(contacts)), order;
  for (int c = 0; c < contacts; ++c) {
    int& island = number[to_size(sets.find(c))];
    if (island < 0) {
      island = static_cast<int>(order.size());
      order.push_back(island);
    }
    island_of[to_size(c)] = island;
  }
  const ContactIslands found = make_lists(static_cast<int>(order.size()), [&](const auto& put) {
    for (int c = 0; c < contacts; ++c) put(island_of[to_size(c)], c);
  });
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return found.of(a).size() < found.of(b).size(); });
  return make_lists(found.count(), [&](const auto& put) {
    for (int k = 0; k < found.count(); ++k) {
      for (const int c : found.of(order[to_size(k)])) put(k, c);
    }
  });
}

}  // namespace bipot
