#include "bench/command/watched_trade.h"

#include "bench/command/progress_bar.h"
#include "core/base/interrupt.h"

namespace bipot {

FinishedTrade run_watched_trade(TradeRequest request, const OutputFlags& flags) {
  const InterruptGuard interrupt;
  std::optional<ProgressBar> bar;
  request.interrupted = &InterruptGuard::requested;
  if (!flags.quiet) request.warn = &warn_once;
  request.progress = [&](long done, long total, const std::string& what) {
    if (!bar) bar.emplace(total, flags.silent());
    bar->update(done, what);
  };
  return run_trade(request);
}

}  // namespace bipot
