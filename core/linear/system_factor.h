#pragma once

#include "core/linear/frontal_lu.h"
#include "core/linear/sparse_factor.h"

namespace bipot {

/// A factorisation of a sparse square matrix, wherever it is done: by this process alone
/// (LocalFactor), or by several together (solvers/parallel/parallel_factor.h).
class SystemFactor {
 public:
  virtual ~SystemFactor() = default;
  SystemFactor(const SystemFactor&) = delete;
  SystemFactor& operator=(const SystemFactor&) = delete;

  /// A: compressed, rows ascending; for LocalFactor of symmetric pattern with the diagonal. False:
  /// singular to working precision or not finite. Throws std::bad_alloc, FactorStopped.
  [[nodiscard]] virtual bool factor(const SparseMatrix& A) = 0;
  /// x = A⁻¹ b without refinement. Requires a successful factor().
  virtual void solve(const Vector& b, Vector& x) = 0;
  /// -1 or +1: sign of det A. Requires a successful factor().
  virtual int determinant_sign() const = 0;

 protected:
  SystemFactor() = default;
};

/// Multifrontal (frontal_lu.h), by SparseLU if its pivots are too small.
class LocalFactor final : public SystemFactor {
 public:
  /// `strategy`: of SparseLU. `stop`: ends factorisations, SparseLU's only before they begin.
  explicit LocalFactor(SparseLU::Strategy strategy, const FactorStop& stop = {})
      : lu_(strategy), stop_(stop) {
    fronts_.stop_by(stop);
  }

  [[nodiscard]] bool factor(const SparseMatrix& A) override;
  void solve(const Vector& b, Vector& x) override;
  int determinant_sign() const override;
  /// True if the last factor is multifrontal.
  bool by_fronts() const { return by_fronts_; }

 private:
  FrontalLU fronts_;
  SparseLU lu_;
  FactorStop stop_;
  bool by_fronts_ = false;
};

}  // namespace bipot
