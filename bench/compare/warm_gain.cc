#include "bench/compare/warm_gain.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bench/measure/statistics.h"
#include "bench/report/labels.h"

namespace bipot {
namespace {

const ComparisonRow* cold_row(const Comparison& comparison, const ComparisonRow& warm) {
  for (const ComparisonRow& row : comparison.rows) {
    if (row.problem == warm.problem && row.solver == warm.solver && row.tol == warm.tol) {
      return &row;
    }
  }
  return nullptr;
}

}  // namespace

std::vector<WarmGain> warm_gains(const Comparison& comparison) {
  struct Ratios {
    std::vector<double> time, iterations;
  };
  std::vector<WarmGain> gains;
  std::vector<Ratios> ratios;
  for (const ComparisonRow& warm : comparison.warm_rows) {
    const ComparisonRow* cold = cold_row(comparison, warm);
    if (cold == nullptr) continue;
    auto at = std::find_if(gains.begin(), gains.end(), [&](const WarmGain& g) {
      return g.solver == warm.solver && g.tol == warm.tol;
    });
    if (at == gains.end()) {
      WarmGain fresh;
      fresh.solver = warm.solver;
      fresh.tol = warm.tol;
      at = gains.insert(gains.end(), fresh);
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

std::string to_text(const WarmGain& gain) {
  const auto ratio = [](double x) {
    return std::isfinite(x) ? fmt::format("{:.2f}", x) : std::string("-");
  };
  return fmt::format(
      "warm start, {:<14} tol {}: solved {} of {} (cold {}), time over cold {}, iterations {}",
      gain.solver, tolerance_label(gain.tol), gain.solved_warm, gain.problems, gain.solved_cold,
      ratio(gain.time_ratio), ratio(gain.iterations_ratio));
}

}  // namespace bipot
