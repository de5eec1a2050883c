#pragma once

#include <string>

#include "bench/compare/extreme_matrix.h"

namespace bipot {

/// The command that measures one cell again.
std::string cell_command(const ExtremeCell& cell);

/// One line for each cell.
std::string to_csv(const ExtremeMatrix& matrix);
/// Cases by solvers, a sign for each cell, the counts, and every wrong cell in words.
std::string to_text(const ExtremeMatrix& matrix);
/// The short form for a README: groups by solvers, cells solved of those that can be.
std::string to_markdown(const ExtremeMatrix& matrix);
/// A page that needs no other file: the matrix in colours, what each case is and what is known of
/// it, and every cell with its figures.
std::string to_html(const ExtremeMatrix& matrix);

}  // namespace bipot
