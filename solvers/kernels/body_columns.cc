#include "solvers/kernels/body_columns.h"

#include <algorithm>
#include <numeric>

namespace bipot {

ContactsOfDofs::ContactsOfDofs(const ContactProblem& p) : start(to_size(p.num_dofs()) + 1, 0) {
  // The columns of a contact follow one another: what was seen last tells whether a dof has it.
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

BodyColumns::BodyColumns(const ContactProblem& p, const Vector& scale)
    : problem_(p), scale_(scale), contacts_(p) {}

/// Column by column, as a list of all pairs takes several times its memory.
BodyColumns::Pattern BodyColumns::pattern() const {
  const ContactProblem& p = problem_;
  const int n = p.num_dofs();
  std::vector<int> rows, seen(to_size(n), -1);
  const auto column = [&](int j) {
    rows.clear();
    const auto add = [&](Eigen::Index row) {
      if (seen[to_size(row)] == j) return;
      seen[to_size(row)] = j;
      rows.push_back(static_cast<int>(row));
    };
    add(j);
    for (SparseMatrix::InnerIterator it(p.A, j); it; ++it) add(it.row());
    for (int k = contacts_.start[to_size(j)]; k < contacts_.start[to_size(j) + 1]; ++k) {
      for (int a = 0; a < p.dim; ++a) {
        for (SparseMatrix::InnerIterator it(p.H, contacts_.contact[to_size(k)] * p.dim + a); it;
             ++it) {
          if (it.value() != 0) add(it.row());
        }
      }
    }
  };
  Pattern pattern;
  pattern.start.resize(to_size(n) + 1);
  for (int j = 0; j < n; ++j) {
    column(j);
    pattern.start[to_size(j) + 1] = pattern.start[to_size(j)] + static_cast<int>(rows.size());
  }
  pattern.row.resize(to_size(pattern.start.back()));
  std::fill(seen.begin(), seen.end(), -1);
  for (int j = 0; j < n; ++j) {
    column(j);
    std::sort(rows.begin(), rows.end());
    std::copy(rows.begin(), rows.end(), pattern.row.begin() + pattern.start[to_size(j)]);
  }
  return pattern;
}

template <int D>
void BodyColumns::add_contacts(int j, const double* blocks, const FrontColumn& to) const {
  const SparseMatrix& H = problem_.H;
  for (int k = contacts_.start[to_size(j)]; k < contacts_.start[to_size(j) + 1]; ++k) {
    const int c = contacts_.contact[to_size(k)];
    const double* const block = blocks + static_cast<std::ptrdiff_t>(c) * (D * D);
    Local<D> own = Local<D>::Zero();  // row j of G
    for (int a = 0; a < D; ++a) {
      for (SparseMatrix::InnerIterator it(H, c * D + a); it; ++it) {
        if (it.row() == j) own[a] = it.value() * scale_[c * D + a];
      }
    }
    for (int a = 0; a < D; ++a) {
      double weight = 0;  // of row a of Gᵀ: R times row j, and the scale
      for (int b = 0; b < D; ++b) weight += block[a * D + b] * own[b];
      weight *= scale_[c * D + a];
      for (SparseMatrix::InnerIterator it(H, c * D + a); it; ++it) {
        const int row = static_cast<int>(it.row());
        if (it.value() != 0 && to.takes(row)) to[row] += it.value() * weight;
      }
    }
  }
}

void BodyColumns::add(int j, const double* blocks, const FrontColumn& to) const {
  for (SparseMatrix::InnerIterator it(problem_.A, j); it; ++it) {
    const int row = static_cast<int>(it.row());
    if (to.takes(row)) to[row] += it.value();
  }
  dispatch_dim(problem_.dim, [&](auto d) { add_contacts<d()>(j, blocks, to); });
}

void BodyColumns::momentum(const Vector& s, Vector& g) const {
  g.setZero(problem_.num_dofs());
  for (int row = 0; row < problem_.num_rows(); ++row) {
    const double push = scale_[row] * s[row];
    for (SparseMatrix::InnerIterator it(problem_.H, row); it; ++it)
      g[it.row()] += it.value() * push;
  }
}

}  // namespace bipot
