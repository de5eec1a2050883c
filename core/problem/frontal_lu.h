#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>

#include "core/problem/frontal_tree.h"
#include "core/problem/sparse_factor.h"
#include "core/types.h"

namespace bipot {

/// Sparse LU of a matrix of symmetric pattern, by dense fronts (multifrontal method: Duff and Reid
/// 1983, Liu 1992): the columns of a front are eliminated by dense kernels, rows are exchanged
/// among these only. So nothing depends on the values but the exchanges, and the analysis holds
/// for all of them; a pivot that is small against the rows that the front may not take makes the
/// factor inaccurate. `largest_multiplier()` tells, and whoever factors looks. Rows and columns are
/// scaled beforehand by powers of two, to about one.
///
/// Real is what the factor is kept in: double, or float at half the memory, whose solutions are
/// good to 1e-6 at best and need refinement.
template <class Real>
class FrontalLU {
 public:
  FrontalLU();
  ~FrontalLU();
  FrontalLU(FrontalLU&&) noexcept;
  FrontalLU& operator=(FrontalLU&&) noexcept;

  /// A: compressed, rows ascending, symmetric pattern with the diagonal. False: a pivot is zero or
  /// not finite, or memory ran out.
  [[nodiscard]] bool factor(const SparseMatrix& A);
  /// x = A⁻¹ b without refinement. Requires a successful factor().
  void solve(const Vector& b, Vector& x) const;
  /// x[k] = A⁻¹ b_k of the columns of B, kRightSides (eight_right_sides.h) at most, in the time of two
  /// single ones; each the same bits whatever the others are. Requires a successful factor().
  void solve(const SparseColumns& B, Vector* x) const requires std::is_same_v<Real, double>;
  /// -1 or +1: sign of det A. Requires a successful factor().
  int determinant_sign() const;
  /// max |l_ij| of the rows that a pivot could not be exchanged with.
  double largest_multiplier() const;
  /// Numbers in L and U together.
  std::size_t num_entries() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

extern template class FrontalLU<double>;
extern template class FrontalLU<float>;

}  // namespace bipot
