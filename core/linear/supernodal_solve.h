#pragma once

#include <cstddef>
#include <vector>

#include "core/base/types.h"

namespace bipot {

/// x = L⁻ᵀ L⁻¹ b for a lower triangular L of supernodes, many times.
///
/// For a supernode with triangle T and rectangle R it stores M = [I; R] T⁻¹ (the partitioned
/// inverse: Alvarado, Pothen and Schreiber 1993). Both passes are then products of a small dense
/// matrix and a vector, without divisions or dependent operations:
///
///     forward   y1 <- M1 y1,   y2 <- y2 - M2 y1        backward   x1 <- M1ᵀ y1 - M2ᵀ x2
///
/// M is stored in strips of four registers of rows (32 numbers), by columns, without the
/// part right of its diagonal. Both passes read it once, in order: they are limited by memory.
/// Therefore all is in single precision. The result has its rounding times the condition of L:
/// callers correct it by their residual. All instruction sets sum in the same order.
class SupernodalSolve {
 public:
  /// Columns of a lower triangular matrix with common rows: a triangle of `columns` on top, a
  /// rectangle below.
  struct Supernode {
    int first, columns, rows;  ///< first column; rows of triangle and rectangle
    const int* below;          ///< numbers of the rectangle's rows, ascending; not copied
    const float* values;       ///< by columns, `rows` apart; the triangle's upper part is not read
  };
  /// Numbers stored for a supernode of this size, including zeros that fill the strips.
  static std::size_t num_entries(int columns, int rows);
  /// Starts a matrix of this number of supernodes, which take `entries`; drops the one before.
  void begin(int supernodes, std::size_t entries);
  /// The supernodes in the order of their columns.
  void add(const Supernode& supernode);
  /// x <- L⁻ᵀ L⁻¹ x. No allocation.
  void solve(float* x);

 private:
  struct Block {
    int first, columns, rows;
    const int* below;
    std::size_t value;  // where its numbers begin
  };
  std::vector<Block> blocks_;
  std::vector<float> value_;           // strips
  std::vector<float> given_, result_;  // scratch of a block
  std::vector<float> partial_;         // the same, a slice a column
  std::vector<float> inverse_;         // the same of add()
};

}  // namespace bipot
