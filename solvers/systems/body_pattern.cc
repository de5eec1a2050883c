#include "solvers/systems/body_pattern.h"

#include <algorithm>
#include <utility>

namespace bipot {

Lists<> contacts_of_dofs(const ContactProblem& p) {
  // The columns of a contact are consecutive: the contact seen last tells whether it acts on a dof.
  std::vector<int> last(to_size(p.num_dofs()));
  return make_lists(p.num_dofs(), [&](const auto& put) {
    std::fill(last.begin(), last.end(), -1);
    for (int row = 0; row < p.num_rows(); ++row) {
      const int c = row / p.dim;
      for (SparseMatrix::InnerIterator it(p.H, row); it; ++it) {
        const int dof = static_cast<int>(it.row());
        if (it.value() != 0 && std::exchange(last[to_size(dof)], c) != c) put(dof, c);
      }
    }
  });
}

/// Column by column, since a list of all pairs takes several times the memory.
BodyPattern::BodyPattern(const ContactProblem& p, const Lists<>& contacts,
                         const std::vector<int>& dofs)
    : start(dofs.size() + 1, 0) {
  const int n = static_cast<int>(dofs.size());
  std::vector<int> unknown_of(to_size(p.num_dofs()), -1), rows, seen(dofs.size(), -1);
  for (int i = 0; i < n; ++i) unknown_of[to_size(dofs[to_size(i)])] = i;
  const auto column = [&](int j) {
    rows.clear();
    const auto add = [&](int i) {
      if (i < 0 || seen[to_size(i)] == j) return;
      seen[to_size(i)] = j;
      rows.push_back(i);
    };
    add(j);
    const int dof = dofs[to_size(j)];
    for (SparseMatrix::InnerIterator it(p.A, dof); it; ++it) add(unknown_of[to_size(it.row())]);
    for (const int c : contacts.of(dof)) {
      for (int h = c * p.dim; h < (c + 1) * p.dim; ++h) {
        for (SparseMatrix::InnerIterator it(p.H, h); it; ++it) {
          if (it.value() != 0) add(unknown_of[to_size(it.row())]);
        }
      }
    }
  };
  for (int j = 0; j < n; ++j) {
    column(j);
    start[to_size(j) + 1] = start[to_size(j)] + static_cast<int>(rows.size());
  }
  row.resize(to_size(start.back()));
  std::fill(seen.begin(), seen.end(), -1);
  for (int j = 0; j < n; ++j) {
    column(j);
    std::sort(rows.begin(), rows.end());
    std::copy(rows.begin(), rows.end(), row.begin() + start[to_size(j)]);
  }
}

}  // namespace bipot
