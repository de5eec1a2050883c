#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/base/types.h"

namespace bipot {

// Dense factorisations by LAPACK, for small problems and for tests of rank.

/// P A = L U of a square matrix with row exchanges (dgetrf).
class DenseLu {
 public:
  explicit DenseLu(const Eigen::MatrixXd& A);

  /// False if a pivot is exactly zero or A is not finite: the other members must not be called
  /// then.
  bool ok() const { return ok_; }
  /// An estimate of 1 / (|A| |A⁻¹|) in the norm of column sums (dgecon).
  double reciprocal_condition() const;
  Vector solve(Vector b) const;
  Eigen::MatrixXd inverse() const;

 private:
  Eigen::MatrixXd factors_;
  std::vector<int> exchanges_;
  double norm_ = 0;  // of A
  bool ok_ = false;
};

/// The smallest of all x that minimise |A x - b| (dgelsy: QR with column pivoting). The rank is cut
/// off when the condition exceeds 1 / `threshold`. A and b must be finite.
Vector least_norm_solution(Eigen::MatrixXd A, Vector b, double threshold);

/// Number of pivots of a QR with column pivoting (dgeqp3) above `threshold` times the largest. A
/// must be finite.
int numerical_rank(Eigen::MatrixXd A, double threshold);

}  // namespace bipot
