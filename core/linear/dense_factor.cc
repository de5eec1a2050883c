#include "core/linear/dense_factor.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/linear/dense_turn.h"

extern "C" {
void dgetrf_(const int* m, const int* n, double* a, const int* lda, int* ipiv, int* info);
void dgecon_(const char* norm, const int* n, const double* a, const int* lda, const double* anorm,
             double* rcond, double* work, int* iwork, int* info);
void dgetrs_(const char* trans, const int* n, const int* nrhs, const double* a, const int* lda,
             const int* ipiv, double* b, const int* ldb, int* info);
void dgetri_(const int* n, double* a, const int* lda, const int* ipiv, double* work,
             const int* lwork, int* info);
void dgelsy_(const int* m, const int* n, const int* nrhs, double* a, const int* lda, double* b,
             const int* ldb, int* jpvt, const double* rcond, int* rank, double* work,
             const int* lwork, int* info);
void dgeqp3_(const int* m, const int* n, double* a, const int* lda, int* jpvt, double* tau,
             double* work, const int* lwork, int* info);
void dsyev_(const char* jobz, const char* uplo, const int* n, double* a, const int* lda, double* w,
            double* work, const int* lwork, int* info);
}

namespace bipot {
namespace {

/// Calls routine(work, length, info) for the required length, then with that workspace.
template <class Routine>
void with_workspace(Routine&& routine) {
  int length = -1, info = 0;
  double wish = 0;
  const DenseTurn turn;
  routine(&wish, &length, &info);
  length = std::max(1, static_cast<int>(wish));
  std::vector<double> work(to_size(length));
  if (info == 0) routine(work.data(), &length, &info);
  if (info < 0) throw std::logic_error("LAPACK refuses an argument");
}

using Orthogonal = Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>;

Orthogonal orthogonal(const Eigen::MatrixXd& A, double threshold) {
  Orthogonal factor;
  factor.setThreshold(threshold);
  factor.compute(A);
  return factor;
}

}  // namespace

DenseLu::DenseLu(const Eigen::MatrixXd& A) : factors_(A), exchanges_(to_size(A.rows())) {
  const int n = static_cast<int>(A.rows());
  if (n == 0 || !A.allFinite()) return;
  norm_ = A.cwiseAbs().colwise().sum().maxCoeff();
  int info = 0;
  const DenseTurn turn;
  dgetrf_(&n, &n, factors_.data(), &n, exchanges_.data(), &info);
  ok_ = info == 0;
}

double DenseLu::reciprocal_condition() const {
  const int n = static_cast<int>(factors_.rows());
  std::vector<double> work(to_size(4 * n));
  std::vector<int> integers(to_size(n));
  double reciprocal = 0;
  int info = 0;
  const DenseTurn turn;
  dgecon_("1", &n, factors_.data(), &n, &norm_, &reciprocal, work.data(), integers.data(), &info);
  return reciprocal;
}

Vector DenseLu::solve(Vector b) const {
  const int n = static_cast<int>(factors_.rows()), one = 1;
  int info = 0;
  const DenseTurn turn;
  dgetrs_("N", &n, &one, factors_.data(), &n, exchanges_.data(), b.data(), &n, &info);
  return b;
}

Eigen::MatrixXd DenseLu::inverse() const {
  Eigen::MatrixXd result = factors_;
  const int n = static_cast<int>(factors_.rows());
  with_workspace([&](double* work, const int* length, int* info) {
    dgetri_(&n, result.data(), &n, exchanges_.data(), work, length, info);
  });
  return result;
}

Vector least_norm_solution(Eigen::MatrixXd A, Vector b, double threshold) {
  const int rows = static_cast<int>(A.rows()), columns = static_cast<int>(A.cols()), one = 1;
  if (rows == 0 || columns == 0) return Vector::Zero(columns);
  const int longer = std::max(rows, columns);
  b.conservativeResize(longer);
  std::vector<int> exchanges(to_size(columns));
  int rank = 0;
  with_workspace([&](double* work, const int* length, int* info) {
    dgelsy_(&rows, &columns, &one, A.data(), &rows, b.data(), &longer, exchanges.data(), &threshold,
            &rank, work, length, info);
  });
  b.conservativeResize(columns);
  return b;
}

int numerical_rank(Eigen::MatrixXd A, double threshold) {
  const int rows = static_cast<int>(A.rows()), columns = static_cast<int>(A.cols());
  const int pivots = std::min(rows, columns);
  if (pivots == 0) return 0;
  std::vector<int> exchanges(to_size(columns));
  std::vector<double> scales(to_size(pivots));
  with_workspace([&](double* work, const int* length, int* info) {
    dgeqp3_(&rows, &columns, A.data(), &rows, exchanges.data(), scales.data(), work, length, info);
  });
  const Vector sizes = A.diagonal().cwiseAbs();
  return static_cast<int>((sizes.array() > threshold * sizes.maxCoeff()).count());
}

double smallest_eigenvalue(Eigen::MatrixXd A) {
  const int n = static_cast<int>(A.rows());
  Vector values(n);
  with_workspace([&](double* work, const int* length, int* info) {
    dsyev_("N", "L", &n, A.data(), &n, values.data(), work, length, info);
  });
  return values[0];
}

std::pair<Vector, Eigen::Index> least_norm_and_rank(const Eigen::MatrixXd& A, const Vector& b,
                                                    double threshold) {
  const Orthogonal factor = orthogonal(A, threshold);
  return {factor.solve(b), factor.rank()};
}

Eigen::MatrixXd least_norm_columns(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                                   double threshold) {
  return orthogonal(A, threshold).solve(B);
}

std::pair<Eigen::MatrixXd, Eigen::MatrixXd> inverse_and_left_null_space(const Eigen::MatrixXd& A,
                                                                        double threshold) {
  const Eigen::Index rows = A.rows();
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(rows, rows);
  const Orthogonal factor = orthogonal(A, threshold);
  const Eigen::MatrixXd q = factor.householderQ() * identity;
  return {factor.solve(identity), q.rightCols(rows - factor.rank())};
}

}  // namespace bipot
