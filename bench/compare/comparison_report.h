#pragma once

#include <string>

#include "bench/compare/comparison.h"
#include "bench/compare/comparison_measures.h"
#include "bench/report/build_info.h"
#include "bench/report/json_output.h"
#include "bench/report/labels.h"

namespace bipot {

/// What a reader must know to make the comparison again.
struct ReportContext {
  std::string command;  ///< as it was typed
  /// The command that makes the figures of one problem: "bipot compare {} --tols ...".
  std::string command_of_target;
  ComparisonOptions options;
  BuildInfo build;
  std::string date;
};

/// True errors and times [s] at which the report draws profiles.
inline constexpr double kProfileAccuracies[] = {1e-1, 1e-2, 1e-4, 1e-6};
inline constexpr double kBudgets[] = {0.01, 0.1, 1};

/// The whole table with its context.
Json to_json(const Comparison& comparison, const ReportContext& context);
/// CSV of the rows, in the order of the table.
std::string to_csv(const Comparison& comparison);
/// For a terminal of 100 columns: problem x solver at the tightest tolerance, and the counts.
std::string to_text(const Comparison& comparison);
}  // namespace bipot
