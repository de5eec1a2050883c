#pragma once

#include "bench/tradeoff/trade_request.h"

namespace bipot {

/// Runs the request with a progress bar on the terminal unless `quiet`; Ctrl-C ends it early.
FinishedTrade run_watched_trade(TradeRequest request, bool quiet);

}  // namespace bipot
