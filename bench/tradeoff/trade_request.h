#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/tradeoff/trade_analysis.h"
#include "bench/tradeoff/trade_report.h"

namespace bipot {

/// What a user asks for. What is left empty takes its default, or the smaller one of `quick`.
struct TradeRequest {
  std::vector<std::string> scenes;  ///< empty: trade_targets()
  std::vector<std::string> solvers = {"auto"};
  std::vector<double> tols, step_sizes, overlaps, stiffness;
  std::optional<double> time_limit, accuracy;
  std::optional<int> replicas;
  std::string witness = "apgd";  ///< TradeOptions::witness
  bool quick = false;
};

/// Who watches a run; both may be empty.
struct TradeWatch {
  std::function<bool()> interrupted;
  /// `total` bounds the number of settings: that of replicas is not known before.
  std::function<void(long done, long total, const std::string& what)> progress;
};

/// The runs, what they say, and how to make them again.
struct FinishedTrade {
  AnalysedTrade analysed;
  TradeContext context;
};

/// Runs what is asked for. Throws std::invalid_argument for a request that makes no sense, and as
/// run_trade(TradeOptions).
FinishedTrade run_trade(const TradeRequest& request, const TradeWatch& watch);

/// trade.csv, trade.json and trade.html. Throws FileError.
void write_trade(const std::filesystem::path& folder, const FinishedTrade& finished);

}  // namespace bipot
