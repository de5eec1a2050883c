#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "bench/trade/trade_request.h"

namespace bipot {

struct TradeFlags {
  TradeRequest request;
  bool quiet = false;
  std::string out, json;
};

/// Declares `bipot trade`.
CLI::App* add_trade_command(CLI::App& app, TradeFlags& flags);

/// Runs whole simulations and writes what they say. Returns an ExitCode: 0 when all were run,
/// whatever came of them.
int trade_command(const TradeFlags& flags);

}  // namespace bipot
