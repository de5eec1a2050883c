#include "solvers/systems/body_columns.h"

#include <numeric>
#include <vector>

namespace bipot {

BodyColumns::BodyColumns(const ContactProblem& p, const Vector& scale)
    : problem_(p), wrenches_(p.H, p.dim, scale), contacts_(contacts_of_dofs(p)) {}

BodyPattern BodyColumns::pattern() const {
  std::vector<int> all(to_size(problem_.num_dofs()));
  std::iota(all.begin(), all.end(), 0);
  return {problem_, contacts_, all};
}

template <int D>
void BodyColumns::add_contacts(int j, const double* blocks,
                               const FrontalCholesky::Column& to) const {
  for (const int c : contacts_.of(j)) {
    const double* const block = blocks + static_cast<std::ptrdiff_t>(c) * (D * D);
    int at = wrenches_.begin(c);
    while (wrenches_.dof(at) != j) ++at;
    const double* const own = wrenches_.row(at);
    Local<D> column = Local<D>::Zero();  // R (row j of G)ᵀ
    for (int a = 0; a < D; ++a) {
      for (int b = 0; b < D; ++b) column[a] += block[a * D + b] * own[b];
    }
    for (int i = wrenches_.begin(c); i < wrenches_.end(c); ++i) {
      if (!to.takes(wrenches_.dof(i))) continue;
      double sum = 0;
      for (int a = 0; a < D; ++a) sum += wrenches_.row(i)[a] * column[a];
      to.add(wrenches_.dof(i), sum);
    }
  }
}

void BodyColumns::add(int j, const double* blocks, const FrontalCholesky::Column& to) const {
  for (SparseMatrix::InnerIterator it(problem_.A, j); it; ++it) {
    const int row = static_cast<int>(it.row());
    if (to.takes(row)) to.add(row, it.value());
  }
  dispatch_count(problem_.dim, [&](auto d) { add_contacts<d()>(j, blocks, to); });
}

void BodyColumns::residual(const Vector& s, const Vector& v, Vector& g) const {
  g.resize(problem_.num_dofs());
  wrenches_.momentum(s, g);
  g.noalias() -= problem_.A * v;
}

}  // namespace bipot
