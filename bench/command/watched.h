#pragma once

#include <optional>
#include <string>

#include "bench/command/progress_bar.h"
#include "bench/measure/watch.h"
#include "core/base/interrupt.h"

namespace bipot {

/// The result of work(watch): with a progress bar unless `quiet`; Ctrl-C asks it to end early.
template <class Work>
auto watched(bool quiet, Work work) {
  const InterruptGuard interrupt;
  std::optional<ProgressBar> bar;
  return work(Watch{.interrupted = &InterruptGuard::requested,
                    .progress = [&](long done, long total, const std::string& what) {
                      if (!bar) bar.emplace(total, quiet);
                      bar->update(done, what);
                    }});
}

}  // namespace bipot
