#include "solvers/systems/body_pattern.h"

#include <algorithm>
#include <numeric>

namespace bipot {

ContactsOfDofs::ContactsOfDofs(const ContactProblem& p) : start(to_size(p.num_dofs()) + 1, 0) {
  // The columns of a contact are consecutive: the contact seen last tells whether it acts on a dof.
  std::vector<int> last(to_size(p.num_dofs()));
  const auto each = [&](const auto& use) {
    std::fill(last.begin(), last.end(), -1);
    for (int row = 0; row < p.num_rows(); ++row) {
      const int c = row / p.dim;
      for (SparseMatrix::InnerIterator it(p.H, row); it; ++it) {
        const std::size_t dof = to_size(it.row());
        if (it.value() == 0 || last[dof] == c) continue;
        last[dof] = c;
        use(dof, c);
      }
    }
  };
  each([&](std::size_t dof, int) { ++start[dof + 1]; });
  std::partial_sum(start.begin(), start.end(), start.begin());
  contact.resize(to_size(start.back()));
  std::vector<int> next(start.begin(), start.end() - 1);
  each([&](std::size_t dof, int c) { contact[to_size(next[dof]++)] = c; });
}

/// Column by column, since a list of all pairs takes several times the memory.
BodyPattern::BodyPattern(const ContactProblem& p, const ContactsOfDofs& contacts,
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
    const std::size_t dof = to_size(dofs[to_size(j)]);
    for (SparseMatrix::InnerIterator it(p.A, dofs[to_size(j)]); it; ++it) {
      add(unknown_of[to_size(it.row())]);
    }
    for (int k = contacts.start[dof]; k < contacts.start[dof + 1]; ++k) {
      const int first = contacts.contact[to_size(k)] * p.dim;
      for (int h = first; h < first + p.dim; ++h) {
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
