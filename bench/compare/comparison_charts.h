#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "bench/compare/comparison_measures.h"
#include "bench/compare/comparison_success.h"
#include "bench/report/chart.h"

namespace bipot {

/// The charts of a comparison's report. A solver has the same colour, marker and dashes in all of
/// them.

/// Curves of performance_profiles(); `cost` names what is compared, "time".
Chart profile_chart(const std::vector<PerformanceProfile>& profiles, const std::string& cost,
                    const std::string& title);
/// Share of the problems whose error is at most x.
Chart budget_chart(const std::vector<BudgetErrors>& errors, const std::string& title);
/// Share of the cases whose ratio is at most x, one curve for each regret.
Chart regret_chart(const std::vector<Regret>& regrets, const std::vector<std::string>& names);

/// Share of the problems of one size that a solver brings below each tolerance.
Chart success_chart(const std::vector<SuccessCurve>& curves, std::string_view size);

/// True error against time, with the rows of the Pareto front; one marker for each tolerance.
Chart work_precision_chart(const Comparison& comparison, const Comparison::Problem& problem);
/// True error against tolerance.
Chart tolerance_chart(const Comparison& comparison, const Comparison::Problem& problem);
/// Guarded error against iteration.
Chart history_chart(const Comparison& comparison, const Comparison::Problem& problem);

/// One series at one tolerance against the degrees of freedom, with the fitted powers.
Chart growth_chart(const std::vector<Growth>& all, const std::string& series, double tol,
                   Growth::Measure quantity);

}  // namespace bipot
