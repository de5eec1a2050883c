#pragma once

#include <string>

#include "bench/report/build_info.h"
#include "bench/report/json_output.h"
#include "bench/tradeoff/trade_analysis.h"

namespace bipot {

/// Data that a reader needs to repeat the run.
struct TradeContext {
  std::string command;           ///< as it was typed
  std::string command_of_scene;  ///< with {} for the scene
  double time_limit = 0;
  BuildInfo build;
  std::string date;
};

Json to_json(const AnalysedTrade& analysed, const TradeContext& context);
/// One line for each scene, run and outcome: tidy, for a spreadsheet or a data frame.
std::string to_csv(const Trade& trade);
/// For a terminal of 100 columns.
std::string to_text(const AnalysedTrade& analysed);

}  // namespace bipot
