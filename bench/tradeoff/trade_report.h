#pragma once

#include <string>

#include "bench/report/document.h"
#include "bench/tradeoff/trade_analysis.h"

namespace bipot {

/// Data that a reader needs to repeat the run.
struct TradeContext {
  Provenance made;
  std::string command_of_scene;  ///< with {} for the scene
  double time_limit = 0;
};

Json to_json(const AnalysedTrade& analysed, const TradeContext& context);
/// A row for each scene, run and outcome: tidy, for a spreadsheet or a data frame.
Table outcome_table(const Trade& trade);
/// Scene by scene: the answer, where errors come from, springs, charts and all settings. Headings
/// begin at level 3, for a section of another report.
Document trade_document(const AnalysedTrade& analysed, const TradeContext& context);
/// The same as a page of its own, with its provenance.
Document trade_page(const AnalysedTrade& analysed, const TradeContext& context);

}  // namespace bipot
