#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "bench/experiments/claim_report.h"
#include "bench/experiments/validation_row.h"

namespace bipot {

/// Measurements of `bipot validate`.
struct ValidationPage {
  std::string command, solver;
  bool quick = false, complete = true;
  std::vector<ValidationRow> rows;                               ///< judged
  std::map<std::string, std::vector<Findings::Figure>> figures;  ///< by group

  void add(Experiment::Result result);
  int held() const;
  int undecided() const;
  int failed() const;  ///< neither
};

/// A line for each row and tolerance: validate.csv.
Table points_table(const ValidationPage& page);
/// A line for each row: verdicts.csv, and in a terminal.
Table verdicts_table(const ValidationPage& page);
/// For a terminal, with the reason of each failed row.
std::string to_text(const ValidationPage& page);
/// Groups in the order of the page.
std::vector<std::string> groups_of(const ValidationPage& page);
/// Relative error against tolerance, a line for each row of the group. Values 0 (inside the
/// bounds), or below 1e-12, are shown on the axis.
Chart error_chart(const ValidationPage& page, const std::string& group);
/// The page and the JSON: an item for each group.
ClaimReport to_report(const ValidationPage& page);

/// index.html, validate.json, validate.csv, verdicts.csv, and each chart as .svg, .csv and .gp.
/// Throws FileError.
void write_validation(const std::filesystem::path& folder, const ValidationPage& page);

}  // namespace bipot
