#pragma once

#include <cstddef>
#include <vector>

#include "core/base/types.h"

namespace bipot {

/// Columns of a lower triangular matrix that have their rows in common: a triangle of `columns` on
/// top, a rectangle below.
struct Supernode {
  int first, columns, rows;  ///< first column; rows of triangle and rectangle
  const int* below;          ///< numbers of the rectangle's rows, ascending; not copied
  const double* values;      ///< by columns, `rows` apart; the triangle's upper part is not read
};

/// x = L⁻ᵀ L⁻¹ b for a lower triangular L of supernodes, many times.
///
/// Of a supernode with triangle T and rectangle R it keeps M = [I; R] T⁻¹ (the partitioned inverse:
/// Alvarado, Pothen and Schreiber 1993), so that both passes are products of a small dense matrix
/// and a vector, without divisions and without one number waiting for the one before:
///
///     forward   y1 <- M1 y1,   y2 <- y2 - M2 y1        backward   x1 <- M1ᵀ y1 - M2ᵀ x2
///
/// M lies in strips of four registers of rows (16 numbers), by columns, without what stands
/// right of its diagonal: both passes read it once, in order, and memory is what takes the time.
/// Rounding is that of substitution times the condition of the triangles. Sums have one order for all
/// instruction sets.
class SupernodalSolve {
 public:
  /// Numbers kept of a supernode of so many columns and rows, zeros that fill the strips included.
  static std::size_t num_entries(int columns, int rows);
  /// Of a matrix of so many supernodes, which take `entries`; forgets the one before.
  void begin(int supernodes, std::size_t entries);
  /// The supernodes in the order of their columns.
  void add(const Supernode& supernode);
  /// x <- L⁻ᵀ L⁻¹ x. No allocation.
  void solve(double* x);

 private:
  struct Block {
    int first, columns, rows;
    const int* below;
    std::size_t value;  // where its numbers begin
  };
  std::vector<Block> blocks_;
  std::vector<double> value_;           // strips
  std::vector<double> given_, result_;  // scratch of a block
  std::vector<double> partial_;         // the same, a slice a column
  std::vector<double> inverse_;         // the same of add()
};

}  // namespace bipot
