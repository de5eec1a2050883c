#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/types.h"

namespace bipot {

/// A symmetric pattern with its diagonal: rows of column j row[start[j]] .. row[start[j + 1] - 1],
/// ascending. A view: it refers to its source.
struct SymmetricPattern {
  int size = 0;
  const int* start = nullptr;
  const int* row = nullptr;

  SymmetricPattern(int n, const int* column_start, const int* rows)
      : size(n), start(column_start), row(rows) {}
  /// Pattern of a compressed matrix.
  SymmetricPattern(const SparseMatrix& A)  // NOLINT(google-explicit-constructor)
      : SymmetricPattern(static_cast<int>(A.cols()), A.outerIndexPtr(), A.innerIndexPtr()) {}
  int entries() const { return start[size]; }
};

/// The part of a multifrontal factorisation that depends on the pattern alone, for matrices of
/// symmetric pattern. It has a fill-reducing order (METIS, AMD for small ones) of the groups of
/// columns with the same pattern, and the fronts of supernodes.h.
class FrontalTree {
 public:
  /// The tree of a pattern. The last trees are cached, for instance for a later step with the same
  /// contacts: always the latest, others within 2 MB in all. The result depends on the pattern
  /// alone. Thread-safe. Throws std::bad_alloc.
  static std::shared_ptr<const FrontalTree> of(const SymmetricPattern& A);
  /// A new tree that is not cached.
  static std::shared_ptr<const FrontalTree> analyse(const SymmetricPattern& A);

  /// Empties the cache, for measurements.
  static void forget();

  /// Front s eliminates the columns first[s] .. first[s + 1] - 1 of the new order. Its further rows
  /// and columns start at below[below_start[s]].
  std::vector<int> order;  ///< new to old
  std::vector<int> first, below_start, below, children;
  std::vector<std::int64_t> node_start;  ///< of the front's panel and upper part in the factor
  std::size_t factor_size = 0, stack_size = 0;

  /// True if this is the tree of the pattern of A.
  bool is_of(const SymmetricPattern& A) const;
  int num_fronts() const { return static_cast<int>(first.size()) - 1; }
  /// Columns that the front eliminates, its rows below them, and both.
  int columns(int front) const { return first[to_size(front) + 1] - first[to_size(front)]; }
  int height(int front) const {
    return below_start[to_size(front) + 1] - below_start[to_size(front)];
  }
  int rows(int front) const { return columns(front) + height(front); }
  /// position[i] = position of row i, in the new order, among the rows of the front, if it has that
  /// row.
  void place_rows(int front, int* position) const;
  /// to[k] = position of the child's row k below its columns among the rows of its parent. Computed
  /// for each factor: storing all would take as much memory as `below`.
  void place_child(int child, int parent, int* to) const;
  int size() const { return first.back(); }
  std::size_t num_bytes() const;  ///< of memory

 private:
  void measure();

  // Columns first[g] .. first[g + 1] - 1 have the rows of the groups from group[start[g]] on. Since
  // the pattern is symmetric, columns of one group are equal as rows too.
  struct Pattern {
    std::vector<int> first, start, group;
  } pattern_;
};

}  // namespace bipot
