#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bench/compare/comparison.h"
#include "bench/report/document.h"

namespace bipot {

/// Rows as CSV: header, then one line for each row, every number to the last bit.
std::string csv_header();
std::string to_csv(const Comparison::Row& row);
/// Throws FileError for a file of another kind. A last line that was cut off is dropped.
std::vector<Comparison::Row> read_csv_rows(const std::filesystem::path& path);

/// Histories as CSV: problem, solver, tol, iteration, seconds, epsilon, eta.
std::string history_csv_header();
std::string to_csv(const Comparison::History& history);
/// Throws FileError. Drops a cut last line. Of several histories of a problem and solver the
/// tightest one counts, of equal ones the last.
std::vector<Comparison::History> read_csv_histories(const std::filesystem::path& path);

/// A row's columns, in the order of the file.
struct ComparisonColumn {
  Table::Column column;
  std::function<Table::Cell(const Comparison::Row&)> cell;
  /// Throws FileError for a text that is no such value.
  std::function<void(Comparison::Row&, const std::string&, const std::filesystem::path&)> read;
};
const std::vector<ComparisonColumn>& comparison_columns();

/// All rows, the cold ones first. Pages mark those that missed their tolerance.
Table rows_table(const Comparison& comparison);

}  // namespace bipot
