#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bench/measure/problem_mark.h"
#include "bench/measure/problem_target.h"
#include "bench/measure/watch.h"
#include "core/base/types.h"
#include "solvers/auto/plan.h"

namespace bipot {

/// One solver variant on one problem from one start at one tolerance.
struct MeasuredRow {
  std::string problem, scene;  ///< rows of one scene are left out together in a cross-validation
  ProblemTraits traits;        ///< warm or cold is one of its marks
  ProblemMark mark;
  std::string variant;  ///< "assor sweeps=4", a solver and its parameters; or "auto"
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

/// A solver of the table with parameters that a plan may choose.
struct TunedVariant {
  std::string name;  ///< "assor sweeps=4"
  double power = 0;  ///< its iterations grow as N^power, about; budgets are cut by N^power
};

/// The variants of these solvers; empty: of all solvers of this build but those of other codes.
/// Throws std::invalid_argument for an unknown name, and for auto alone.
std::vector<TunedVariant> tuned_variants(const std::vector<std::string>& solvers);

struct MeasureOptions {
  std::vector<TunedVariant> variants;
  std::vector<double> tols = {1e-2, 1e-4, 1e-8};
  double time_limit = 2;       ///< CPU seconds of one solve
  std::filesystem::path file;  ///< rows are appended as they are made; rows there are kept
  Watch watch;
  std::function<void(const std::string&)> warn;  ///< told of steps that a scene does not reach
};

/// Measures `auto` and every variant on every problem, from 0 and from the problem's start, at all
/// tolerances, where the file has no row, or that of a failure within less time. A solver whose
/// iterates do not depend on the tolerance runs once for all of them. One that is out of time does
/// not run at tighter tolerances. Times are CPU times of this process. Returns all rows of the file.
/// Throws FileError, and std::invalid_argument where its rows are of another problem of that name.
std::vector<MeasuredRow> measure_rows(const std::vector<ProblemSource>& sources,
                                      const MeasureOptions& options);

}  // namespace bipot
