#pragma once

#include <string>

#include "bench/compare/extreme_matrix.h"
#include "bench/report/document.h"

namespace bipot {

/// The command that repeats one cell of the matrix.
std::string cell_command(const ExtremeMatrix& matrix, const ExtremeCell& cell);

/// A row for each cell: extremes.csv.
Table cells_table(const ExtremeMatrix& matrix);
/// Cases by solvers, a sign for each cell, the counts, and every wrong cell as text.
std::string to_text(const ExtremeMatrix& matrix);
/// The short form for a README: groups by solvers, cells solved of those that can be.
std::string to_markdown(const ExtremeMatrix& matrix);
/// The page: the matrix in colours, each case with its known facts, and every cell with its values.
/// As JSON: cells and cases.
Document extremes_page(const ExtremeMatrix& matrix, const Provenance& made);

}  // namespace bipot
