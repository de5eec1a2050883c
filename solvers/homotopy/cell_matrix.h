#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "core/linear/frontal_lu.h"
#include "solvers/homotopy/law_point.h"

namespace bipot {

/// The matrix B of a point's cells, computed line by line from W. Each slot has the column
///
///     opening e_n,   sliding e_t,   plus -(W + D)(1, -mu),   minus -(W + D)(1, +mu),
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
  double entry(int row, Column column, int contact, double normal, double tangential) const;

  const LawProblem& problem_;
  bool paired_;      // d = 2, and both columns of each contact have the same rows
  SparseRows rows_;  // W, if it is not symmetric to the last bit
  std::vector<Column> columns_;
  const Vector* proximal_ = nullptr;
  std::vector<long double> sum_, impulse_;  // scratch of residual()
};

template <class Add>
void CellMatrix::for_column(int contact, Column column, Add&& add) const {
  const int d = problem_.dim, n = contact * d;
  if (!is_impulse(column)) {
    add(column == Column::kOpening ? n : n + 1, 1.0);
    return;
  }
  SparseMatrix::InnerIterator a(problem_.W, n);
  if (d == 1) {
    for (; a; ++a) {
      add(static_cast<int>(a.row()),
          entry(static_cast<int>(a.row()), column, contact, a.value(), 0));
    }
    return;
  }
  if (paired_) {
    const int* const row = problem_.W.innerIndexPtr() + problem_.W.outerIndexPtr()[n];
    const double* const normal = problem_.W.valuePtr() + problem_.W.outerIndexPtr()[n];
    const int count = problem_.W.outerIndexPtr()[n + 1] - problem_.W.outerIndexPtr()[n];
    for (int k = 0; k < count; ++k) {
      add(row[k], entry(row[k], column, contact, normal[k], normal[count + k]));
    }
    return;
  }
  constexpr int kEnd = std::numeric_limits<int>::max();
  SparseMatrix::InnerIterator b(problem_.W, n + 1);
  while (a || b) {
    const int row_a = a ? static_cast<int>(a.row()) : kEnd;
    const int row_b = b ? static_cast<int>(b.row()) : kEnd;
    const int row = std::min(row_a, row_b);
    double normal = 0, tangential = 0;
    if (row_a == row) {
      normal = a.value();
      ++a;
    }
    if (row_b == row) {
      tangential = b.value();
      ++b;
    }
    add(row, entry(row, column, contact, normal, tangential));
  }
}

/// Entry of an impulse column, from the entries of W there.
inline double CellMatrix::entry(int row, Column column, int contact, double normal,
                                double tangential) const {
  const int n = contact * problem_.dim;
  if (problem_.dim == 1) return -normal - (row == n ? (*proximal_)[n] : 0);
  const double tangent = problem_.tangent(contact, column);
  double value = -normal - tangent * tangential;
  if (row == n) value -= (*proximal_)[n];
  if (row == n + 1) value -= tangent * (*proximal_)[n + 1];
  return value;
}

}  // namespace bipot
