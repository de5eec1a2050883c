#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/types.h"

namespace bipot {

/// A symmetric pattern with its diagonal: rows of column j row[start[j]] .. row[start[j + 1] - 1],
/// ascending. Refers to what it is made of.
struct SymmetricPattern {
  int size = 0;
  const int* start = nullptr;
  const int* row = nullptr;

  SymmetricPattern(int n, const int* column_start, const int* rows)
      : size(n), start(column_start), row(rows) {}
  /// Of a compressed matrix.
  SymmetricPattern(const SparseMatrix& A)  // NOLINT(google-explicit-constructor)
      : SymmetricPattern(static_cast<int>(A.cols()), A.outerIndexPtr(), A.innerIndexPtr()) {}
  int entries() const { return start[size]; }
};

/// What a factorisation by fronts takes from the pattern alone, for matrices of symmetric pattern:
/// a fill-reducing order (METIS, AMD for small ones) of the groups of columns that have one
/// pattern, and the supernodes of CHOLMOD's analysis.
class FrontalTree {
 public:
  /// The tree of a pattern. The trees of the last
  /// few patterns are kept for whoever asks next, a later step of a run with the same contacts
  /// among them, the latest always and others as long as all take 2 MB at most; the answer depends
  /// on the pattern alone. Safe from several threads. Null when memory ran out.
  static std::shared_ptr<const FrontalTree> of(const SymmetricPattern& A);
  /// The same, made anew and not kept.
  static std::shared_ptr<const FrontalTree> analyse(const SymmetricPattern& A);

  /// Drops the trees that are kept, for measurements of what that saves.
  static void forget();

  /// Front s eliminates the columns first[s] .. first[s + 1] - 1 of the new order. Its further rows
  /// and columns are below[below_start[s]] and on.
  std::vector<int> order;  ///< new to old
  std::vector<int> first, below_start, below, children;
  std::vector<std::int64_t> node_start;  ///< of the front's panel and upper part in the factor
  std::size_t factor_size = 0, stack_size = 0;

  /// Whether A has the pattern that this was made of.
  bool is_of(const SymmetricPattern& A) const;
  int num_fronts() const { return static_cast<int>(first.size()) - 1; }
  /// Columns that the front eliminates, its rows below them, and both.
  int columns(int front) const { return first[to_size(front) + 1] - first[to_size(front)]; }
  int height(int front) const {
    return below_start[to_size(front) + 1] - below_start[to_size(front)];
  }
  int rows(int front) const { return columns(front) + height(front); }
  /// position[i] = place of row i, in the new order, among the rows of the front, for those it has.
  void place_rows(int front, int* position) const;
  /// to[k] = place of the child's row k below its columns among the rows of its parent. Found anew for
  /// each factor: lists of all of them are as long as `below`.
  void place_child(int child, int parent, int* to) const;
  int size() const { return first.back(); }
  std::size_t num_bytes() const;  ///< of memory

 private:
  void measure();

  // Columns first[g] .. first[g + 1] - 1 have the rows of the groups group[start[g]] and on: as the
  // pattern is symmetric, columns that are alike are so as rows too.
  struct Pattern {
    std::vector<int> first, start, group;
  } pattern_;
};

}  // namespace bipot
