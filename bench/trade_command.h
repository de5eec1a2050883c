#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

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

/// Runs whole simulations and writes what they say. Returns an ExitCode: 0 when all were run,
/// whatever came of them.
int trade_command(const TradeFlags& flags);

}  // namespace bipot
