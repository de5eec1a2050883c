#pragma once

#include <string>

#include "bench/command/remaining_time.h"
#include "core/base/stopwatch.h"

namespace bipot {

/// Progress on standard error. On a terminal one line, as wide as it, redrawn at most ten times a
/// second. Elsewhere, as in a batch job, a line each 10 %, but none in the first second. (Debian 12
/// packages no C++ progress-bar library.)
class ProgressBar {
 public:
  ProgressBar(long total, bool quiet);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// `done` of total are finished; `note` follows the bar, as far as there is room.
  void update(long done, const std::string& note);

 private:
  long total_;
  bool quiet_, terminal_;
  Stopwatch watch_;
  RemainingTime remaining_;
  double drawn_ = -1;  // when, in seconds
  long tenths_ = 0;    // that lines were written for
};

/// The line of a progress bar on a terminal with so many columns.
std::string progress_line(long done, long total, double seconds_left, const std::string& note,
                          int columns);

}  // namespace bipot
