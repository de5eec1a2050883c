#pragma once

#include <cstddef>
#include <vector>

#include "core/linear/sparse_factor.h"
#include "core/problem/contact_problem.h"
#include "solvers/kernels/contact_residual.h"
#include "solvers/kernels/contact_scaling.h"

namespace bipot {

/// The regularised problem of a proximal step (proximal_point.h) as a square system of equations
/// with a fixed sparsity pattern.
///
///   contact form, unknown x:      f_c(x_c, w_c) = 0,  w = W' x + b' + (x - x_k) / kappa
///   mixed form, unknown (y, x):   A' y - H' x = 0,  f_c(x_c, w_c) = 0,
///                                 w = H'ᵀ y + b' + (x - x_k) / kappa
///
/// W' = D^{-1/2} W D^{-1/2}, A' = S A S, H' = S H D^{-1/2}, S = diag(A)^{-1/2} and b' = D^{-1/2}
/// u_free / unit, unit = ‖D^{-1/2} u_free‖. All quantities are dimensionless.
class NewtonSystem {
 public:
  /// The equation f of a contact. kInequality: f = w, for a solver that keeps x >= 0 by itself.
  enum class Residual { kAlartCurnier, kFischerBurmeister, kInequality };

  /// Copies all data that it needs. The mixed form needs A and H, the contact form W. Throws
  /// std::runtime_error if A is not positive definite. kFischerBurmeister has no rolling friction.
  NewtonSystem(const ContactProblem& problem, const Vector& delassus_diagonal, Residual residual,
               bool mixed);

  int size() const { return dofs_ + rows(); }
  /// The pattern in compressed rows, columns sorted: size() + 1 starts, and the columns.
  const std::vector<int>& row_start() const { return row_start_; }
  const std::vector<int>& columns() const { return columns_; }

  /// kappa and the anchor s_k of the regularised problem, s_k in the problem's variables.
  void set_proximal(double kappa, const Vector& anchor_impulse);
  double kappa() const { return kappa_; }

  /// Unknowns at the impulse s, dynamics exact.
  Vector unknowns(const Vector& s) const;
  /// x of the unknowns z, size() values.
  Eigen::Map<const Vector> scaled_impulse(const double* z) const {
    return Eigen::Map<const Vector>(z + dofs_, rows());
  }
  /// Impulse of the unknowns in the problem's variables.
  Vector impulse(const double* z) const;
  /// ‖x - x_k‖ / kappa: the effect of the proximal term.
  double proximal_residual(const double* z) const;

  /// f, size() values.
  void residual(const double* z, double* f) const;
  /// Values of the Jacobian in the order of the pattern.
  void jacobian(const double* z, double* values) const;

 private:
  int rows() const { return contacts_ * d_; }
  Vector velocity(const double* z) const;
  template <class F>
  void dispatch_kind(const F& f) const;
  template <ContactRows D>
  LocalResidual<D> equation(int c, const Eigen::Map<const Vector>& x, const Vector& w) const;
  template <int D>
  void fill_contact(int c, const LocalResidual<D>& r, double* values) const;
  void build_pattern();
  void add_coupling(const SparseRows& block_rows, int contact, bool own);

  int d_, contacts_, dofs_ = 0;
  Residual residual_;
  bool mixed_, diagonal_mass_ = true;
  double unit_ = 1, kappa_ = 1;
  ContactScaling scaling_;
  Vector b_, anchor_;
  SparseRows W_, A_, H_rows_;
  SparseMatrix H_;
  SparseCholesky mass_factor_;
  std::vector<int> row_start_, columns_;
  std::vector<double> fixed_values_;         // rows of the dynamics, mixed form
  std::vector<std::size_t> coupling_start_;  // per contact, into coupling_ / D
  std::vector<double> coupling_;             // D values per coupled column
  std::vector<int> coupling_column_;         // the column of each
  std::vector<int> own_position_;            // contact form: first own column in the row
};

}  // namespace bipot
