#pragma once

#include <filesystem>

#include "core/problem_files/problem_file.h"

namespace bipot {

/// Reads a problem in the text format of Siconos Numerics (.dat): FrictionContactProblem (d, number
/// of contacts, W, q, mu) or GlobalFrictionContactProblem (d, number of contacts, M, H, f, w, mu).
/// Or GenericMechanicalProblem: M in blocks, q, and for each block row its type, 2 for equality rows
/// (joints), which are eliminated, or 4 for a contact in space, and mu; no other types.
/// The file does not name its kind. After its first matrix a local problem has exactly (d + 1) nc
/// numbers left, in older versions one more (a flag); a global problem always has more.
///
/// A matrix: storage (0 dense, 1 sparse blocks, 2 sparse), rows, columns, then
///   - dense: rows, columns again, the entries column by column;
///   - sparse blocks: number of blocks, of block rows and of block columns, accumulated row and
///     column extents, sizes of the two index arrays, row starts, block columns, then each block:
///     its number and its entries column by column. No blocks: nothing follows the first 0;
///   - sparse: origin, then a CSparse listing as triplets, columns or rows.
/// Throws FileError, naming the line.
ProblemFile read_siconos_text(const std::filesystem::path& path);

}  // namespace bipot
