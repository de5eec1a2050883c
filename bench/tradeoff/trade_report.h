#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "bench/report/document.h"
#include "bench/tradeoff/trade_analysis.h"

namespace bipot {

/// A trade with its analysis, made once for all reports, and the data that a reader needs to repeat
/// it. The analysis points into the trade: both are moved together and never copied.
struct FinishedTrade {
  explicit FinishedTrade(Trade whole) : trade(std::move(whole)), scenes(analyse_trade(trade)) {}
  FinishedTrade(FinishedTrade&&) = default;
  FinishedTrade& operator=(FinishedTrade&&) = default;
  Trade trade;
  std::vector<SceneTrade> scenes;
  Provenance made;
  std::string command_of_scene;  ///< with {} for the scene
  double time_limit = 0;         ///< CPU of one run                                        [s]
};

/// Runs the trade. `command`: that makes it; `command_of_scene`: with {} for a scene.
FinishedTrade finished_trade(const Trade::Options& options, const std::string& command,
                             const std::string& command_of_scene);
Json to_json(const FinishedTrade& finished);
/// A row for each scene, run and outcome: tidy, for a spreadsheet or a data frame.
Table outcome_table(const Trade& trade);
/// Scene by scene: the answer, where errors come from, springs, charts and all settings. Headings
/// begin at level 3, for a section of another report.
Document trade_document(const FinishedTrade& finished);
/// The same as a page of its own, with its provenance.
Document trade_page(const FinishedTrade& finished);
/// Writes trade.csv, trade.json and trade.html. Throws FileError.
void write_trade(const std::filesystem::path& folder, const FinishedTrade& finished);

}  // namespace bipot
