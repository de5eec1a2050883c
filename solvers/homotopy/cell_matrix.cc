#include "solvers/homotopy/cell_matrix.h"

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

/// True if the d columns of each contact have the same rows, as for an assembled W.
bool has_blocks(const SparseMatrix& W, int d) {
  const int* const row = W.innerIndexPtr();
  const int* const start = W.outerIndexPtr();
  for (int j = 0; j + 1 < W.cols(); ++j) {
    if ((j + 1) % d != 0 &&
        !std::equal(row + start[j], row + start[j + 1], row + start[j + 1], row + start[j + 2])) {
      return false;
    }
  }
  return true;
}

}  // namespace

CellMatrix::CellMatrix(const LawProblem& problem)
    : problem_(problem),
      alike_(has_blocks(problem.W, problem.dim)),
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
  if (!is_impulse(column)) return slot == n + static_cast<int>(column) ? 1 : 0;
  double w[3] = {};
  for (int k = 0; k < d; ++k) w[k] = problem_.W.coeff(slot, n + k);
  return entry(slot, column, contact, w);
}

void CellMatrix::add_column(int slot, FrontalLU::Line& to) const {
  for_column(slot / problem_.dim, columns_[to_size(slot)],
             [&](int row, double value) { to.add(row, value); });
}

void CellMatrix::add_row(int row, FrontalLU::Line& to) const {
  const int d = problem_.dim, own = row / d;
  const auto add = [&](int contact, const double* values) {
    const int n = contact * d;
    for (int slot = n; slot < n + d; ++slot) {
      if (!to.takes(slot)) continue;
      const Column column = columns_[to_size(slot)];
      if (is_impulse(column)) {
        to.add(slot, entry(row, column, contact, values));
      } else if (row == n + static_cast<int>(column)) {
        to.add(slot, 1);
      }
    }
  };
  const Rows w = rows();
  const int end = w.start[row + 1];
  bool own_seen = false;
  for (int k = w.start[row]; k < end;) {
    const int contact = w.column[k] / d, n = contact * d;
    double values[3] = {};
    for (; k < end && w.column[k] < n + d; ++k) values[w.column[k] - n] = w.value[k];
    add(contact, values);
    own_seen |= contact == own;
  }
  constexpr double kZero[3] = {};
  if (!own_seen) add(own, kZero);
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
    if (!is_impulse(column)) {
      sum[n + static_cast<int>(column)] -= value;
      continue;
    }
    impulse[n] += value;
    for (int k = 1; k < d; ++k) impulse[n + k] += problem_.tangent(contact, column, k) * value;
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
