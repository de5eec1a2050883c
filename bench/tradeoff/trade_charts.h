#pragma once

#include <vector>

#include "bench/report/document.h"
#include "bench/tradeoff/trade_analysis.h"

namespace bipot {

/// The charts of one scene, those with points: the solver's error over the others against the
/// tolerance, the error of the outcome against cost, penetration against cost.
std::vector<Figure> trade_charts(const SceneTrade& scene);

}  // namespace bipot
