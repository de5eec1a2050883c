#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/linear/system_factor.h"
#include "core/problem/delassus.h"
#include "solvers/systems/body_system.h"

namespace bipot {

/// Solves (I + R W) x = g, the linear system of every Newton method on the contact law. R is
/// block-diagonal (one d x d block for each contact), not symmetric, and may be singular.
///
/// Two forms of the same system:
///   - body: the contacts are eliminated, x = g - R Hᵀ K⁻¹ H g with K = A + H R Hᵀ in the degrees
///     of freedom that contacts touch. Needs a diagonal A. Sparse and small for packings of disks,
///     but x is a difference of large numbers if R W is large.
///   - contact: I + R W itself, in the rows of the contacts. Any W, symmetric or not.
/// Either matrix is factored by LocalFactor, or by a factorisation that the caller provides. kAuto
/// chooses the body form unless it is not available or has more than twice as many unknowns. The
/// determinants of the two forms have the same sign, det K = det A det(I + R W).
class ShiftedDelassus {
 public:
  enum class Form { kAuto, kBody, kContact };

  /// Keeps references to the problem and to `elsewhere`, the factorisation to use instead of
  /// LocalFactor; may be null. `stop` is asked before each factorisation, and in those of
  /// LocalFactor. Throws std::invalid_argument for an impossible form.
  explicit ShiftedDelassus(const ContactProblem& problem, Form form = Form::kAuto,
                           SystemFactor* elsewhere = nullptr, FactorStop stop = {});

  /// R: row-major d x d blocks, contact after contact, [kg]. False: singular to working precision.
  /// Throws std::bad_alloc, FactorStopped.
  [[nodiscard]] bool factor(const std::vector<double>& R);
  /// x = (I + R W)⁻¹ g.
  void solve(const Vector& g, Vector& x) const;
  /// Sign of det(I + R W).
  int determinant_sign() const { return factor_->determinant_sign(); }
  /// True if the last factor is multifrontal.
  bool by_fronts() const { return here_ && here_->by_fronts(); }
  /// The matrix of the last factor: K or I + R W.
  const SparseMatrix& matrix() const { return body_form_ ? body_->matrix() : matrix_; }
  /// The blocks R of the last factor.
  const std::vector<double>& blocks() const { return R_; }

 private:
  void build_contact_pattern();
  void assemble_contact_form();

  const ContactProblem& problem_;
  bool body_form_ = false;
  std::optional<BodySystem> body_;     // of the body form
  SparseMatrix matrix_;                // I + R W of the contact form, fixed pattern
  std::unique_ptr<LocalFactor> here_;  // null where another factors
  SystemFactor* factor_ = nullptr;
  FactorStop stop_;
  std::vector<double> R_;
  mutable Vector wrench_, velocity_, change_;

  // Contact form. Block row c of W as a dense d x k block on the columns column_[start..).
  SparseRows own_delassus_;
  std::vector<int> row_start_;     // c + 1, into the columns of the block rows
  std::vector<double> row_block_;  // d values per column
  std::vector<int> row_slot_;      // d positions per column in matrix_
};

}  // namespace bipot
