#pragma once

#include <memory>

#include "core/types.h"

namespace bipot {

/// Sparse Cholesky factorisation A = L Lᵀ (CHOLMOD, supernodal, METIS or AMD ordering). The
/// symbolic analysis is kept as long as the pattern of A stays the same.
class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  /// Factors the symmetric A (both triangles stored). False when A is not positive definite.
  [[nodiscard]] bool factor(const SparseMatrix& A);
  /// x = A⁻¹ b. Requires a successful factor().
  Vector solve(const Eigen::Ref<const Vector>& b) const;
  /// X = A⁻¹ B for a sparse right-hand side.
  SparseMatrix solve(const SparseMatrix& B) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Sparse LU factorisation of a general square matrix (UMFPACK, 64-bit indices, METIS or AMD
/// ordering). The symbolic analysis is kept as long as the pattern stays the same.
class SparseLU {
 public:
  /// The ordering strategy: symmetric for matrices of symmetric pattern with a strong diagonal.
  enum class Strategy { kAuto, kSymmetric, kUnsymmetric };

  explicit SparseLU(Strategy strategy = Strategy::kAuto);
  ~SparseLU();
  SparseLU(SparseLU&&) noexcept;
  SparseLU& operator=(SparseLU&&) noexcept;

  /// False when A is singular to working precision or memory ran out.
  [[nodiscard]] bool factor(const SparseMatrix& A);
  /// x = A⁻¹ b, with `refinements` steps of iterative refinement. Requires a successful factor().
  Vector solve(const Eigen::Ref<const Vector>& b, int refinements = 0) const;
  /// -1, 0 or +1: sign of det A. Requires a successful factor().
  int determinant_sign() const;
  /// Reciprocal condition estimate of the last factorisation (UMFPACK's cheap diagonal one).
  double rcond() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace bipot
