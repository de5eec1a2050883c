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

}  // namespace bipot
