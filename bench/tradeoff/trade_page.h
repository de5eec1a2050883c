#pragma once

#include <string>

#include "bench/tradeoff/trade_analysis.h"
#include "bench/tradeoff/trade_report.h"

namespace bipot {

/// Headings from <h3> down, for a page that has the rules of trade_style() and a heading of its
/// own ("Whole simulations"). Charts are drawn: throws FileError without gnuplot.
std::string trade_section(const AnalysedTrade& analysed, const TradeContext& context);
/// The page by itself; needs nothing else.
std::string trade_page(const AnalysedTrade& analysed, const TradeContext& context);
/// CSS of the section, all under .trade.
std::string trade_style();

}  // namespace bipot
