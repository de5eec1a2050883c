#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace bipot {

/// Columns of numbers over time, from a CSV file of a run.
struct CurveTable {
  std::string file;                          ///< its name without ".csv"
  std::string part;                          ///< value of a column of words, e.g. a wall; or empty
  std::vector<std::string> names;            ///< with units, as in "time [s]"
  std::vector<std::vector<double>> columns;  ///< one for each name
  /// The column of this name, with or without a unit; null if there is none.
  const std::vector<double>* column(const std::string& name) const;
};

/// The tables of ledger.csv, walls.csv, observables.csv and gates.csv, as far as a folder has them,
/// whatever their columns are. A file with a column of words gives a table for each word. Lines that
/// are cut off do not count. Throws FileError for a file without a column "time".
std::vector<CurveTable> read_curves(const std::filesystem::path& folder);

/// At most `points` rows that look the same: of each stretch of rows every column keeps its smallest
/// and its largest value. A shorter table stays as it is.
CurveTable thinned_curves(const CurveTable& table, std::size_t points);

}  // namespace bipot
