#pragma once

#include <cstdlib>

#include "core/base/triplets.h"

namespace bipot {

/// n x n without zeros, symmetric and positive definite (its diagonal dominates): one front.
inline SparseMatrix full_matrix(int n) {
  Triplets entries;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      entries.emplace_back(i, j, i == j ? 30 : 1.0 / (1 + std::abs(i - j)));
    }
  }
  return from_triplets(n, n, entries);
}

}  // namespace bipot
