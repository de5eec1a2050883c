#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "bench/compare/comparison.h"
#include "bench/measure/problem_target.h"
#include "bench/measure/reference_solution.h"
#include "core/files/folder_lock.h"

namespace bipot {

/// The files of a comparison: rows and histories, read when it is continued and appended to as they
/// are made, references and problems. Without a folder it keeps histories alone.
class ComparisonStore {
 public:
  /// Throws FileError, and std::invalid_argument if the rows of the folder were made under other
  /// limits or another comparison writes into it.
  explicit ComparisonStore(const Comparison::Options& options);

  /// An existing row; null without one.
  const Comparison::Row* find(const std::string& problem, const std::string& solver, double tol,
                              bool warm) const;
  /// Writes the history before the row: a row in the file has its history.
  void append(const Comparison::Row& row, const Comparison::History& history);
  /// After the last row: of lines for one row, rows.csv keeps the last, in the place of the first.
  void finish() const;
  const Comparison::History* history(const std::string& problem, const std::string& solver) const;

  std::optional<ReferenceSolution> reference(const std::string& problem) const;
  /// Writes the reference, and the problem unless it comes from a file.
  void write(const ProblemSource& source, const TestProblem& problem,
             const ReferenceSolution& reference) const;

 private:
  std::filesystem::path reference_path(const std::string& problem) const;

  std::filesystem::path folder_;
  std::map<std::string, Comparison::Row> rows_;
  std::map<std::pair<std::string, std::string>, Comparison::History> histories_;
  std::unique_ptr<FolderLock> lock_;
  std::ofstream rows_file_, history_file_;
};

}  // namespace bipot
