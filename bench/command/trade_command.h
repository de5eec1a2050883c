#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/trade/trade_report.h"

namespace bipot {

struct TradeFlags {
  std::vector<std::string> scenes;  ///< empty: trade_targets()
  std::vector<std::string> solvers = {"auto"};
  std::vector<double> tols, step_sizes, overlaps, stiffness;  ///< empty: the defaults
  std::optional<double> time_limit, accuracy;
  std::optional<int> replicas;
  bool quick = false, quiet = false;
  std::string out, json;
};

/// Declares `bipot trade`.
CLI::App* add_trade_command(CLI::App& app, TradeFlags& flags);

/// What the flags ask for, run; with a progress bar unless `quiet`. Destinations are not looked at.
/// Throws as run_trade.
struct FinishedTrade {
  Trade trade;
  TradeContext context;
};
FinishedTrade run_trade(const TradeFlags& flags, bool quiet);

/// trade.csv, trade.json and trade.html. Throws FileError.
void write_trade(const std::filesystem::path& folder, const FinishedTrade& finished);

/// Runs whole simulations and writes what they say. Returns an ExitCode: 0 when all were run,
/// whatever came of them.
int trade_command(const TradeFlags& flags);

}  // namespace bipot
