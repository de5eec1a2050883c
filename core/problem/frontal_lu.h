#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/types.h"

namespace bipot {

/// What a factorisation by fronts takes from the pattern alone, for matrices of symmetric pattern:
/// a fill-reducing order (METIS, AMD for small ones) of the groups of columns that have one
/// pattern, the supernodes of CHOLMOD's analysis, and where each entry goes.
class FrontalTree {
 public:
  /// The tree of A's pattern, which must be symmetric and hold the diagonal. The trees of the last
  /// few patterns are kept for whoever asks next, a later step of a run with the same contacts
  /// among them; the answer depends on the pattern alone. Safe from several threads. Null when
  /// memory ran out.
  static std::shared_ptr<const FrontalTree> of(const SparseMatrix& A);
  /// The same, made anew and not kept.
  static std::shared_ptr<const FrontalTree> analyse(const SparseMatrix& A);

  /// Drops the trees that are kept, for measurements of what that saves.
  static void forget();

  /// Front s eliminates the columns first[s] .. first[s + 1] - 1 of the new order. Its further rows
  /// and columns are below[below_start[s]] and on, and stand at `relative` in the parent's list.
  std::vector<int> order;  ///< new to old
  std::vector<int> first, below_start, below, relative, children;
  std::vector<std::int64_t> node_start;  ///< of the front's panel and upper part in the factor
  std::vector<int> entry_start, entry_source, entry_target;
  std::size_t factor_size = 0, stack_size = 0;

  /// Whether A has the pattern that this was made of.
  bool is_of(const SparseMatrix& A) const;
  int num_fronts() const { return static_cast<int>(first.size()) - 1; }
  int size() const { return first.back(); }

 private:
  void place_entries(const SparseMatrix& A);
  void measure();

  std::vector<int> pattern_start_, pattern_row_;
};

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
