#include "solvers/systems/body_columns.h"

#include <numeric>
#include <vector>

namespace bipot {

BodyColumns::BodyColumns(const ContactProblem& p, const Vector& scale)
    : problem_(p), scale_(scale), contacts_(p) {}

BodyPattern BodyColumns::pattern() const {
  std::vector<int> all(to_size(problem_.num_dofs()));
  std::iota(all.begin(), all.end(), 0);
  return {problem_, contacts_, all};
}

template <int D>
void BodyColumns::add_contacts(int j, const double* blocks,
                               const FrontalCholesky::Column& to) const {
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

void BodyColumns::add(int j, const double* blocks, const FrontalCholesky::Column& to) const {
  for (SparseMatrix::InnerIterator it(problem_.A, j); it; ++it) {
    const int row = static_cast<int>(it.row());
    if (to.takes(row)) to[row] += it.value();
  }
  dispatch_count(problem_.dim, [&](auto d) { add_contacts<d()>(j, blocks, to); });
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
