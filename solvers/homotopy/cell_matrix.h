#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "core/linear/frontal_lu.h"
#include "solvers/homotopy/law_point.h"

namespace bipot {

/// The matrix B of a point's cells, computed line by line from W. Each slot has the column
///
///     opening e_n,   sliding e_t,   rolling e_m,   a ray -(W + D)(1, ∓mu, ∓mu_r),
///
/// so that U(p) - (W + D) S(p) = B p, with D the diagonal proximal term. Refers to the problem.
class CellMatrix final : public FrontalLU::MatrixByLines {
 public:
  explicit CellMatrix(const LawProblem& problem);

  /// Sets the columns of each slot, and the diagonal of D (m, by reference).
  void set(const std::vector<Column>& columns, const Vector& proximal);
  const std::vector<Column>& columns() const { return columns_; }

  double diagonal(int slot) const override;
  void add_column(int slot, FrontalLU::Line& to) const override;
  void add_row(int row, FrontalLU::Line& to) const override;
  /// Calls add(row, value) for the entries of a column of a contact, rows ascending.
  template <class Add>
  void for_column(int contact, Column column, Add&& add) const;

  /// out = g + weight h - B x for the columns of a point, with D as set. The impulse is summed in
  /// extended precision, since mu times a parameter is not a double. It is multiplied row by row:
  /// sums of 80 bits stay in registers.
  void residual(const std::vector<Column>& columns, const Vector& g, long double weight,
                const Vector& h, const Vector& x, Vector& out);

 private:
  /// W by rows; its columns if it is symmetric to the last bit.
  struct Rows {
    const int* start;
    const int* column;
    const double* value;
  };
  Rows rows() const;
  double entry(int row, Column column, int contact, const double* w) const;

  const LawProblem& problem_;
  bool alike_;       // all columns of each contact have the same rows
  SparseRows rows_;  // W, if it is not symmetric to the last bit
  std::vector<Column> columns_;
  const Vector* proximal_ = nullptr;
  std::vector<long double> sum_, impulse_;  // scratch of residual()
};

template <class Add>
void CellMatrix::for_column(int contact, Column column, Add&& add) const {
  const int d = problem_.dim, n = contact * d;
  if (!is_impulse(column)) {
    add(n + static_cast<int>(column), 1.0);
    return;
  }
  const int* const start = problem_.W.outerIndexPtr() + n;
  const int* const rows = problem_.W.innerIndexPtr();
  const double* const values = problem_.W.valuePtr();
  double w[3] = {};
  if (alike_) {
    const int count = start[1] - start[0];
    for (int k = start[0]; k < start[1]; ++k) {
      for (int j = 0; j < d; ++j) w[j] = values[k + j * count];
      add(rows[k], entry(rows[k], column, contact, w));
    }
    return;
  }
  int at[3];
  std::copy_n(start, d, at);
  for (;;) {
    int row = std::numeric_limits<int>::max();
    for (int j = 0; j < d; ++j) {
      if (at[j] < start[j + 1]) row = std::min(row, rows[at[j]]);
    }
    if (row == std::numeric_limits<int>::max()) return;
    for (int j = 0; j < d; ++j) {
      w[j] = at[j] < start[j + 1] && rows[at[j]] == row ? values[at[j]++] : 0;
    }
    add(row, entry(row, column, contact, w));
  }
}

/// Entry of an impulse column, from the d entries of W there.
inline double CellMatrix::entry(int row, Column column, int contact, const double* w) const {
  const int d = problem_.dim, own = row - contact * d;
  double value = -w[0];
  for (int k = 1; k < d; ++k) value -= problem_.tangent(contact, column, k) * w[k];
  if (own < 0 || own >= d) return value;
  return value - (own == 0 ? 1 : problem_.tangent(contact, column, own)) * (*proximal_)[row];
}

}  // namespace bipot
