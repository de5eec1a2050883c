#pragma once

#include <vector>

#include "core/base/types.h"

namespace bipot {

/// Entries of a sparse matrix, in any order.
using Triplets = std::vector<Eigen::Triplet<double>>;

/// The matrix with these entries. Those of one place are summed.
template <class Sparse = SparseMatrix>
Sparse from_triplets(Eigen::Index rows, Eigen::Index columns, const Triplets& entries) {
  Sparse matrix(rows, columns);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

/// Appends the entries of a matrix, with rows and columns times these factors.
template <class Sparse>
void append_entries(const Sparse& matrix, Triplets& entries, int rows = 1, int columns = 1) {
  for (int k = 0; k < matrix.outerSize(); ++k) {
    for (typename Sparse::InnerIterator it(matrix, k); it; ++it) {
      entries.emplace_back(rows * static_cast<int>(it.row()), columns * static_cast<int>(it.col()),
                           it.value());
    }
  }
}

/// Gives a matrix this size and more entries.
template <class Sparse>
void enlarge(Sparse& matrix, Eigen::Index rows, Eigen::Index columns, Triplets more) {
  append_entries(matrix, more);
  matrix = from_triplets<Sparse>(rows, columns, more);
}

}  // namespace bipot
