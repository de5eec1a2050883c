#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "core/base/types.h"

namespace bipot {

// Dense factorisations, for small problems and for tests of rank.

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

/// Of a symmetric matrix (dsyev); its lower triangle is read. It must be finite and not empty.
double smallest_eigenvalue(Eigen::MatrixXd A);

// By Eigen's complete orthogonal decomposition, which gives the same bits on every machine. Pivots
// of at most `threshold` times the largest count as zero.

/// The smallest of all x that minimise |A x - b|, and the rank of A.
std::pair<Vector, Eigen::Index> least_norm_and_rank(const Eigen::MatrixXd& A, const Vector& b,
                                                    double threshold);
/// The same for each column of B.
Eigen::MatrixXd least_norm_columns(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                                   double threshold);
/// The pseudo-inverse of A, and orthonormal columns that span the null space of Aᵀ.
std::pair<Eigen::MatrixXd, Eigen::MatrixXd> inverse_and_left_null_space(const Eigen::MatrixXd& A,
                                                                        double threshold);

}  // namespace bipot
