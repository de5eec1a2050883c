#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/types.h"

namespace bipot {

/// Sparse Cholesky factorisation A = L Lᵀ (CHOLMOD, METIS or AMD ordering; supernodal where that is
/// quicker, unless built without BIPOT_WITH_GPL). The symbolic analysis is reused while the pattern
/// of A stays the same.
class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  /// Factors the symmetric A (both triangles stored). False if A is not positive definite. Throws
  /// std::bad_alloc.
  [[nodiscard]] bool factor(const SparseMatrix& A);
  /// x = A⁻¹ b. Requires a successful factor().
  Vector solve(const Eigen::Ref<const Vector>& b) const;
  /// X = A⁻¹ B for a sparse right-hand side.
  SparseMatrix solve(const SparseMatrix& B) const;
  /// Numbers stored of L, zeros of the supernodes included. Requires a successful factor().
  std::size_t num_entries() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Sparse LU factorisation of a general square matrix, 64-bit indices: UMFPACK with METIS or AMD
/// ordering, or KLU with AMD if built without BIPOT_WITH_GPL. The symbolic analysis is reused while
/// the pattern stays the same.
class SparseLU {
 public:
  /// The ordering strategy: symmetric for matrices of symmetric pattern with a strong diagonal.
  enum class Strategy { kAuto, kSymmetric, kUnsymmetric };

  explicit SparseLU(Strategy strategy = Strategy::kAuto);
  ~SparseLU();
  SparseLU(SparseLU&&) noexcept;
  SparseLU& operator=(SparseLU&&) noexcept;

  /// False if A is singular to working precision. Throws std::bad_alloc.
  [[nodiscard]] bool factor(const SparseMatrix& A);
  /// x = A⁻¹ b, with `refinements` steps of iterative refinement. Requires a successful factor().
  Vector solve(const Eigen::Ref<const Vector>& b, int refinements = 0) const;
  /// -1, 0 or +1: sign of det A. Requires a successful factor().
  int determinant_sign() const;
  static const char* library();  ///< "UMFPACK" or "KLU"
  /// Numbers in L and U of the last factorisation.
  std::size_t num_entries() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace bipot
