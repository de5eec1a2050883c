#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "bench/build_info.h"
#include "bench/comparison.h"

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

/// The true error by which a problem's solvers are ranked: the resultant force on bodies where it
/// is defined, else the velocity; the guarded error where the problem has several solutions, so
/// that a distance to one of them says nothing.
struct Ranking {
  enum class Measure { kForce, kVelocity, kGuarded };
  Measure measure = Measure::kVelocity;
  double of(const ComparisonRow& row) const;
  std::string_view name() const;
};
Ranking ranking(const ProblemSummary& problem, const std::vector<ComparisonRow>& rows);

/// Rows of a problem that no other row of it beats in both time and ranked error.
std::vector<const ComparisonRow*> pareto_rows(const ProblemSummary& problem,
                                              const std::vector<ComparisonRow>& rows);
/// The row of least time whose ranked error is at most `accuracy`; null without one.
const ComparisonRow* fastest_to(const ProblemSummary& problem,
                                const std::vector<ComparisonRow>& rows, double accuracy);

/// How many problems a solver solved at one tolerance.
struct SolvedCount {
  std::string solver;
  double tol = 0;
  int problems = 0;
  int solved = 0;           ///< guarded error <= tol
  int by_natural_map = 0;   ///< natural map <= 1e-8
  double median_ratio = 0;  ///< of its time to the best solver's, where solved; NaN without one
};
std::vector<SolvedCount> count_solved(const Comparison& comparison, double tol);

/// 1e-6 and not 1e-06.
std::string tolerance_label(double tol);

/// The whole table with its context.
nlohmann::ordered_json to_json(const Comparison& comparison, const ReportContext& context);
/// CSV of the rows, in the order of the table.
std::string to_csv(const Comparison& comparison);
/// For a terminal of 100 columns: problem x solver at the tightest tolerance, and the counts.
std::string to_text(const Comparison& comparison);
/// One page that needs nothing else: no network, no other file.
std::string to_html(const Comparison& comparison, const ReportContext& context);

}  // namespace bipot
