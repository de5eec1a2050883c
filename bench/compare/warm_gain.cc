#include "bench/compare/warm_gain.h"

#include <algorithm>

#include "bench/compare/comparison_measures.h"
#include "bench/report/labels.h"

namespace bipot {
std::vector<WarmGain> warm_gains(const Comparison& comparison) {
  struct Ratios {
    std::vector<double> time, iterations;
  };
  std::vector<WarmGain> gains;
  std::vector<Ratios> ratios;
  for (const Comparison::Row& warm : comparison.warm_rows) {
    const Comparison::Row* cold = row_of(comparison, warm.problem, warm.solver, warm.tol);
    if (cold == nullptr) continue;
    auto at = std::ranges::find_if(
        gains, [&](const WarmGain& g) { return g.solver == warm.solver && g.tol == warm.tol; });
    if (at == gains.end()) {
      at = gains.insert(gains.end(), {.solver = warm.solver, .tol = warm.tol});
      ratios.emplace_back();
    }
    Ratios& of = ratios[static_cast<std::size_t>(at - gains.begin())];
    ++at->problems;
    at->solved_cold += cold->solved() ? 1 : 0;
    at->solved_warm += warm.solved() ? 1 : 0;
    if (!cold->solved() || !warm.solved()) continue;
    if (cold->time() > 0) of.time.push_back(warm.time() / cold->time());
    if (cold->iterations > 0) {
      of.iterations.push_back(static_cast<double>(warm.iterations) / cold->iterations);
    }
  }
  for (std::size_t k = 0; k < gains.size(); ++k) {
    gains[k].time_ratio = median(ratios[k].time);
    gains[k].iterations_ratio = median(ratios[k].iterations);
  }
  return gains;
}

Table warm_table(const std::vector<WarmGain>& gains) {
  Table table{.columns = {{"solver", "solver, warm"},
                          {"tol", "tolerance", tolerance_label},
                          {"problems", "problems", count_label},
                          {"solved_cold", "solved cold", count_label},
                          {"solved_warm", "solved warm", count_label},
                          {"median_time_ratio", "time, warm over cold", ratio_label},
                          {"median_iterations_ratio", "iterations, warm over cold", ratio_label}},
              .key = "warm_starts"};
  for (const WarmGain& g : gains) {
    table.add({g.solver, g.tol, g.problems, g.solved_cold, g.solved_warm, g.time_ratio,
               g.iterations_ratio});
  }
  return table;
}

}  // namespace bipot
