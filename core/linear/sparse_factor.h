#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/types.h"

namespace bipot {

/// Sparse Cholesky factorisation A = L Lᵀ (CHOLMOD, supernodal, METIS or AMD ordering). The
/// symbolic analysis is reused while the pattern of A stays the same.
class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  /// Factors the symmetric A (both triangles stored). False if A is not positive definite.
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

/// Sparse LU factorisation of a general square matrix (UMFPACK, 64-bit indices, METIS or AMD
/// ordering). The symbolic analysis is reused while the pattern stays the same.
class SparseLU {
 public:
  /// The ordering strategy: symmetric for matrices of symmetric pattern with a strong diagonal.
  enum class Strategy { kAuto, kSymmetric, kUnsymmetric };

  explicit SparseLU(Strategy strategy = Strategy::kAuto);
  ~SparseLU();
  SparseLU(SparseLU&&) noexcept;
  SparseLU& operator=(SparseLU&&) noexcept;

  /// False if A is singular to working precision or memory ran out.
  [[nodiscard]] bool factor(const SparseMatrix& A);
  /// x = A⁻¹ b, with `refinements` steps of iterative refinement. Requires a successful factor().
  Vector solve(const Eigen::Ref<const Vector>& b, int refinements = 0) const;
  /// -1, 0 or +1: sign of det A. Requires a successful factor().
  int determinant_sign() const;
  /// Reciprocal condition estimate of the last factorisation (UMFPACK's cheap diagonal one).
  double rcond() const;
  /// Numbers in L and U of the last factorisation.
  std::size_t num_entries() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Columns of a square matrix, compressed, with the 64-bit indices of SuiteSparse. Column j holds
/// the rows row[start[j]] .. row[start[j + 1] - 1], ascending.
struct SparseColumns {
  std::vector<std::int64_t> start{0}, row;
  std::vector<double> value;

  void clear() {
    start.assign(1, 0);
    row.clear();
    value.clear();
  }
  void add(std::int64_t i, double a) {
    row.push_back(i);
    value.push_back(a);
  }
  void end_column() { start.push_back(static_cast<std::int64_t>(row.size())); }
};

/// Fill-reducing order (METIS, through CHOLMOD) of the graph of blocks of `block` consecutive rows
/// of the square A. Two blocks are joined if an entry couples them; rows of a block stay together.
/// Size A.rows(). The pattern of A must be symmetric.
std::vector<std::int64_t> fill_reducing_order(const SparseMatrix& A, int block);

/// Sparse LU (UMFPACK) of many square matrices with nearly one pattern. The caller chooses the
/// column order once. UMFPACK keeps to it, and pivots on the diagonal unless that is small.
class OrderedLU {
 public:
  explicit OrderedLU(std::vector<std::int64_t> order);
  ~OrderedLU();
  OrderedLU(OrderedLU&&) noexcept;
  OrderedLU& operator=(OrderedLU&&) noexcept;

  /// The matrix to be factored next. Changing it invalidates the previous factor.
  SparseColumns& matrix();
  /// False if the matrix is singular to working precision or memory ran out.
  [[nodiscard]] bool factor();
  /// x = A⁻¹ b without refinement. No allocation. Requires a successful factor().
  void solve(const Vector& b, Vector& x) const;
  /// -1, 0 or +1: sign of det A. Requires a successful factor().
  int determinant_sign() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace bipot
