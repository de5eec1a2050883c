#pragma once

#include <vector>

#include "core/problem/sparse_factor.h"
#include "solvers/homotopy/law_point.h"

namespace bipot {

/// The matrix B of a point's cells and its factor: per slot the column
///
///     opening e_n,   sliding e_t,   plus -(W + delta)(1, -mu),   minus -(W + delta)(1, +mu),
///
/// so that U(p) - (W + delta) S(p) = B p. UMFPACK factors B in an order chosen once for W; between
/// factorisations the exchange of a column is a product-form update (Dantzig and Orchard-Hays 1954).
/// [ours] A Schur complement of the exchanged columns would need a second sparse solve a pivot:
/// with 5300 contacts solves take half of all time, the updates a sixth.
class CellBasis {
 public:
  explicit CellBasis(const LawProblem& problem);

  /// Factors B of the point, whose columns must be sorted. False: singular.
  [[nodiscard]] bool factor(const LawPoint& point, double delta);
  /// Number of exchanges since.
  int updates() const { return static_cast<int>(slots_.size()); }
  double delta() const { return delta_; }

  /// x = B⁻¹ g. No allocation.
  void solve(const Vector& g, Vector& x);
  /// y = B⁻¹ times a column that does not stand in B.
  void solve_column(int contact, Column column, Vector& y);
  /// Exchanges the column of `slot` for the one whose y is given. Requires y[slot] != 0.
  void exchange(int slot, const Vector& y);

  /// +1 or -1: sign of det B times (-1)^(number of impulse columns), which is +1 where dt is along
  /// the component of the path that joins t = -infinity to the solution. Requires updates() == 0.
  int orientation(const LawPoint& point) const;

  /// x with B x = g + weight h, improved `refinements` times by residuals in 80 bits: without them
  /// the error is that of delta's condition, 1e-16 / delta. The point's columns are those of B.
  void solve_refined(const LawPoint& point, const Vector& g, long double weight, const Vector& h,
                     int refinements, Vector& x);

 private:
  template <class Add>
  void for_column(int contact, Column column, Add&& add) const;
  void residual(const LawPoint& point, const Vector& g, long double weight, const Vector& h,
                const Vector& x, Vector& out);

  const LawProblem& problem_;
  double delta_ = -1;
  OrderedLU lu_;
  std::vector<int> slots_;       // exchanged, in order
  Eigen::MatrixXd columns_;      // y of each exchange, as many columns as were ever needed
  Vector rhs_, change_, error_;  // scratch
  std::vector<long double> sum_;
};

}  // namespace bipot
