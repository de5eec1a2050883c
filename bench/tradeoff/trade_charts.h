#pragma once

#include <string>
#include <vector>

#include "bench/report/chart.h"
#include "bench/tradeoff/trade_analysis.h"

namespace bipot {

struct CaptionedChart {
  Chart chart;
  std::string caption;
};

/// The charts of one scene, those with points: the solver's error over the others against the
/// tolerance, the error of the outcome against cost, penetration against cost.
std::vector<CaptionedChart> trade_charts(const SceneTrade& scene);

}  // namespace bipot
