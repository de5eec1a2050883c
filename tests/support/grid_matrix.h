#pragma once

#include <cmath>

#include "core/base/portable_random.h"
#include "core/base/triplets.h"

namespace bipot {

/// A grid of side x side nodes with `block` unknowns each, every node coupled to its eight
/// neighbours by blocks without symmetry; `diagonal` added to the diagonal.
inline SparseMatrix grid_matrix(int side, int block, unsigned seed, double diagonal) {
  PortableRandom draw(seed);
  Triplets entries;
  for (int a = 0; a < side * side; ++a) {
    for (int b = 0; b < side * side; ++b) {
      if (std::abs(a / side - b / side) > 1 || std::abs(a % side - b % side) > 1) continue;
      for (int i = 0; i < block; ++i) {
        for (int j = 0; j < block; ++j) {
          const int row = a * block + i, column = b * block + j;
          entries.emplace_back(row, column, draw.symmetric() + (row == column ? diagonal : 0.0));
        }
      }
    }
  }
  const int n = side * side * block;
  return from_triplets(n, n, entries);
}

}  // namespace bipot
