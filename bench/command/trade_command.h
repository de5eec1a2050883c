#pragma once

#include <string>

#include "bench/command/command_line.h"
#include "bench/tradeoff/trade_request.h"

namespace bipot {

struct TradeFlags {
  TradeRequest request;
  bool quiet = false;
  std::string out, json;
};

/// Declares `bipot trade`.
CommandDeclaration add_trade_command(CommandLine& line, TradeFlags& flags);

/// Runs whole simulations and writes their analysis. Returns an ExitCode: 0 if all were run, for
/// any outcome.
int trade_command(const TradeFlags& flags);

}  // namespace bipot
