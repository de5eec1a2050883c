#pragma once

#include <filesystem>
#include <string>

#include "bench/compare/comparison.h"
#include "bench/compare/comparison_measures.h"
#include "bench/report/document.h"

namespace bipot {

/// Data that a reader needs to repeat the comparison.
struct ReportContext {
  Provenance made;
  /// The command that makes the figures of one problem: "bipot compare {} --tols ...".
  std::string command_of_target;
  Comparison::Options options;
};

/// True errors and times [s] at which the report draws profiles.
inline constexpr double kProfileAccuracies[] = {1e-1, 1e-2, 1e-4, 1e-6};
inline constexpr double kBudgets[] = {0.01, 0.1, 1};

/// True errors of rows that met a tolerance.
Table meaning_table(const Comparison& comparison);
/// The cases of a regret, the worst first.
Table regret_table(const Regret& regret);

/// The whole table with its context.
Json to_json(const Comparison& comparison, const ReportContext& context);
/// CSV of the rows, in the order of the table.
std::string to_csv(const Comparison& comparison);
/// For a terminal of 100 columns: problem x solver at the tightest tolerance, and the counts.
std::string to_text(const Comparison& comparison);
/// The page. `more` comes before the problem-by-problem part.
Document comparison_page(const Comparison& comparison, const ReportContext& context,
                         const Document& more = {});

/// Writes comparison.csv, success.csv, several.csv, comparison.json and report.html into an
/// existing folder. `more` and the keys of `more_json` are added. Throws FileError.
void write_report(const std::filesystem::path& folder, const Comparison& comparison,
                  const ReportContext& context, const Document& more = {},
                  const Json* more_json = nullptr);

}  // namespace bipot
