#include "bench/command/progress_bar.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace bipot {

ProgressBar::ProgressBar(long total, bool quiet)
    : total_(std::max(total, 1L)), active_(!quiet && isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  if (active_) fmt::print(stderr, "\r\033[K");
}

void ProgressBar::update(long done, const std::string& note) {
  if (!active_) return;
  const double elapsed = watch_.seconds();
  if (elapsed - drawn_ < 0.1 && done < total_) return;
  drawn_ = elapsed;
  constexpr int kWidth = 30;
  const int filled = static_cast<int>(kWidth * done / total_);
  const double left = done > 0 ? elapsed * static_cast<double>(total_ - done) / done : 0;
  fmt::print(stderr, "\r\033[K[{}{}] {}/{}  {:.0f} s left  {}", std::string(filled, '#'),
             std::string(kWidth - filled, '.'), done, total_, left, note);
  std::fflush(stderr);
}

}  // namespace bipot
