#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/tradeoff/trade_analysis.h"
#include "bench/tradeoff/trade_report.h"

namespace bipot {

/// Request of a user. Empty entries take their default, or the smaller one of `quick`.
struct TradeRequest {
  std::vector<std::string> scenes;  ///< empty: trade_targets()
  std::vector<std::string> solvers = {"auto"};
  std::vector<double> tols, step_sizes, accuracies, overlaps, stiffness;
  std::optional<double> time_limit, negligible;
  std::optional<int> replicas;
  std::string witness = "apgd";  ///< Trade::Options::witness
  bool quick = false;
  std::function<bool()> interrupted;             ///< may be empty
  std::function<void(const std::string&)> warn;  ///< likewise: Trade::Options::warn
  /// `total` is an upper bound: the number of replicas is not known before. May be empty.
  std::function<void(long done, long total, const std::string& what)> progress;
};

/// Runs the request. Throws std::invalid_argument for an inconsistent request, and as
/// run_trade(Trade::Options).
FinishedTrade run_trade(const TradeRequest& request);

/// Writes trade.csv, trade.json and trade.html. Throws FileError.
void write_trade(const std::filesystem::path& folder, const FinishedTrade& finished);

}  // namespace bipot
