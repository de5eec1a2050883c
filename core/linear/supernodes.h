#pragma once

#include <cstdint>
#include <vector>

namespace bipot {

struct SymmetricPattern;

/// Fronts of a Cholesky factor: groups of consecutive columns that are eliminated together.
struct Supernodes {
  std::vector<int> first;        ///< first column of each, and the number of columns
  std::vector<int> below_start;  ///< of each in `below`, and the end
  std::vector<int> below;        ///< rows of its columns that are not its own, ascending
};

/// Fronts of A with its columns in the order `order` (new to old), a postorder of the elimination
/// tree (Liu 1990). `entries`: of each new column of the factor, the diagonal included. Columns
/// with the same rows form a front. A front is joined with its parent while few of the numbers
/// stored are zeros (relaxed supernodes: Ashcraft and Grimes 1989; limits by size as in Chen, Davis,
/// Hager, Rajamanickam 2008).
Supernodes supernodes(const SymmetricPattern& A, const std::vector<int>& order,
                      const std::vector<std::int64_t>& entries);

}  // namespace bipot
