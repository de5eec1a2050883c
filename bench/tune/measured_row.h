#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/types.h"
#include "solvers/auto/plan.h"

namespace bipot {

/// One solver variant on one problem from one start at one tolerance.
struct MeasuredRow {
  std::string problem, scene;  ///< rows of one scene are left out together in a cross-validation
  ProblemTraits traits;        ///< warm or cold is one of its marks
  std::string variant;         ///< "assor sweeps=4", a solver and its parameters; or "auto"
  int iterations = 0;
  double seconds = kNaN;  ///< CPU time until solved, or until it was given up
  bool solved = false;
  double limit = kNaN;  ///< CPU seconds that it had
};

/// The problem's rows of one start and tolerance belong together.
std::string instance_of(const MeasuredRow& row);

std::string measured_csv_header();
std::string to_csv(const MeasuredRow& row);
/// No file: no rows. Throws FileError with the line.
std::vector<MeasuredRow> read_measured_rows(const std::filesystem::path& path);

}  // namespace bipot
