#include "solvers/homotopy/cell_matrix.h"

#include <algorithm>

namespace bipot {
namespace {

/// Empty if the rows of W are its columns, to the last bit.
SparseRows rows_unless_symmetric(const SparseMatrix& W) {
  SparseRows rows(W);
  const bool same =
      std::equal(rows.outerIndexPtr(), rows.outerIndexPtr() + W.cols() + 1, W.outerIndexPtr()) &&
      std::equal(rows.innerIndexPtr(), rows.innerIndexPtr() + W.nonZeros(), W.innerIndexPtr()) &&
      std::equal(rows.valuePtr(), rows.valuePtr() + W.nonZeros(), W.valuePtr());
  return same ? SparseRows() : rows;
}

/// True if the columns 2 i and 2 i + 1 have the same rows, as for an assembled W.
bool has_pairs(const SparseMatrix& W) {
  const int* const row = W.innerIndexPtr();
  const int* const start = W.outerIndexPtr();
  for (int j = 0; j < W.cols(); j += 2) {
    if (!std::equal(row + start[j], row + start[j + 1], row + start[j + 1], row + start[j + 2])) {
      return false;
    }
  }
  return true;
}

}  // namespace

CellMatrix::CellMatrix(const LawProblem& problem)
    : problem_(problem),
      paired_(problem.dim == 2 && has_pairs(problem.W)),
      rows_(rows_unless_symmetric(problem.W)) {}

CellMatrix::Rows CellMatrix::rows() const {
  if (rows_.rows() > 0) return {rows_.outerIndexPtr(), rows_.innerIndexPtr(), rows_.valuePtr()};
  const SparseMatrix& W = problem_.W;
  return {W.outerIndexPtr(), W.innerIndexPtr(), W.valuePtr()};
}

void CellMatrix::set(const std::vector<Column>& columns, const Vector& proximal) {
  columns_ = columns;
  proximal_ = &proximal;
}

double CellMatrix::diagonal(int slot) const {
  const int d = problem_.dim, contact = slot / d, n = contact * d;
  const Column column = columns_[to_size(slot)];
  if (!is_impulse(column)) return slot == (column == Column::kOpening ? n : n + 1) ? 1 : 0;
  return entry(slot, column, contact, problem_.W.coeff(slot, n),
               d > 1 ? problem_.W.coeff(slot, n + 1) : 0);
}

void CellMatrix::add_column(int slot, FrontalLU::Line& to) const {
  for_column(slot / problem_.dim, columns_[to_size(slot)],
             [&](int row, double value) { to.add(row, value); });
}

void CellMatrix::add_row(int row, FrontalLU::Line& to) const {
  const int d = problem_.dim, own = row / d;
  const auto add = [&](int contact, double normal, double tangential) {
    const int n = contact * d;
    for (int slot = n; slot < n + d; ++slot) {
      if (!to.takes(slot)) continue;
      const Column column = columns_[to_size(slot)];
      if (is_impulse(column)) {
        to.add(slot, entry(row, column, contact, normal, tangential));
      } else if (row == (column == Column::kOpening ? n : n + 1)) {
        to.add(slot, 1);
      }
    }
  };
  const Rows w = rows();
  const int end = w.start[row + 1];
  bool own_seen = false;
  for (int k = w.start[row]; k < end;) {
    const int contact = w.column[k] / d, n = contact * d;
    double normal = 0, tangential = 0;
    for (; k < end && w.column[k] < n + d; ++k) {
      (w.column[k] == n ? normal : tangential) = w.value[k];
    }
    add(contact, normal, tangential);
    own_seen |= contact == own;
  }
  if (!own_seen) add(own, 0, 0);
}

void CellMatrix::residual(const std::vector<Column>& columns, const Vector& g, long double weight,
                          const Vector& h, const Vector& x, Vector& out) {
  const int d = problem_.dim, m = problem_.num_rows();
  sum_.resize(to_size(m));
  for (int i = 0; i < m; ++i) sum_[to_size(i)] = static_cast<long double>(g[i]) + weight * h[i];
  impulse_.assign(to_size(m), 0);
  long double* const sum = sum_.data();
  long double* const impulse = impulse_.data();
  for (int slot = 0; slot < m; ++slot) {
    const long double value = x[slot];
    const Column column = columns[to_size(slot)];
    const int contact = slot / d, n = contact * d;
    if (column == Column::kOpening) {
      sum[n] -= value;
    } else if (column == Column::kSliding) {
      sum[n + 1] -= value;
    } else {
      impulse[n] += value;
      if (d > 1) impulse[n + 1] += problem_.tangent(contact, column) * value;
    }
  }
  out.resize(m);
  const Rows w = rows();
  for (int i = 0; i < m; ++i) {
    long double even = sum[i] + (*proximal_)[i] * impulse[i], odd = 0;
    int k = w.start[i];
    for (; k + 1 < w.start[i + 1]; k += 2) {
      even += w.value[k] * impulse[w.column[k]];
      odd += w.value[k + 1] * impulse[w.column[k + 1]];
    }
    if (k < w.start[i + 1]) even += w.value[k] * impulse[w.column[k]];
    out[i] = static_cast<double>(even + odd);
  }
}

}  // namespace bipot
