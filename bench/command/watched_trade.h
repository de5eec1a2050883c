#pragma once

#include "bench/command/command_options.h"
#include "bench/tradeoff/trade_request.h"

namespace bipot {

/// Runs the request with cautions and a progress bar, as far as the flags allow; Ctrl-C ends it
/// early.
FinishedTrade run_watched_trade(TradeRequest request, const OutputFlags& flags);

}  // namespace bipot
