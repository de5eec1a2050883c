#pragma once

#include <SuiteSparse_config.h>

#include <utility>
#include <vector>

#include "core/base/types.h"

namespace bipot {

/// Compressed columns with 64-bit indices and the last pattern: SuiteSparse's own layout.
struct LongColumns {
  std::vector<SuiteSparse_long> start, row;
  std::vector<double> value;
  SuiteSparse_long size = 0;

  /// Copies A (sorted, compressed). True if the pattern is that of the previous call.
  bool assign(const SparseMatrix& A, bool upper_only) {
    std::vector<SuiteSparse_long> new_start(to_size(A.cols()) + 1, 0), new_row;
    new_row.reserve(to_size(A.nonZeros()));
    value.clear();
    value.reserve(to_size(A.nonZeros()));
    for (int k = 0; k < A.outerSize(); ++k) {
      for (SparseMatrix::InnerIterator it(A, k); it; ++it) {
        if (upper_only && it.row() > it.col()) continue;
        new_row.push_back(it.row());
        value.push_back(it.value());
      }
      new_start[to_size(k) + 1] = static_cast<SuiteSparse_long>(new_row.size());
    }
    const bool same = size == A.cols() && new_start == start && new_row == row;
    size = A.cols();
    start = std::move(new_start);
    row = std::move(new_row);
    return same;
  }
};

}  // namespace bipot
