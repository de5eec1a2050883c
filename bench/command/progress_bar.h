#pragma once

#include <string>

#include "core/base/stopwatch.h"

namespace bipot {

/// A one-line progress bar on standard error, redrawn at most ten times a second; silent unless
/// standard error is a terminal. (Debian 12 packages no C++ progress-bar library.)
class ProgressBar {
 public:
  ProgressBar(long total, bool quiet);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// `done` of total are finished; `note` follows the bar.
  void update(long done, const std::string& note);

 private:
  long total_;
  bool active_;
  Stopwatch watch_;
  double drawn_ = -1;  // when, in seconds
};

}  // namespace bipot
