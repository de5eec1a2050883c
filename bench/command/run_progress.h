#pragma once

#include <filesystem>
#include <string>

#include "bench/command/progress_bar.h"
#include "core/motion/time_stepping.h"

namespace bipot {

/// Progress of a run: on standard error, and a line each 10 % in the file run.log of its folder.
class RunProgress {
 public:
  /// `folder`: empty, no log. A run that goes on in its own folder appends to its log. Throws
  /// FileError if the log cannot be written.
  RunProgress(long steps, bool quiet, const std::filesystem::path& folder, bool resume);

  /// `done`: steps of this run; `time` at its end.                                            [s]
  template <int D>
  void add(const StepReport<D>& report, long done, double time);

 private:
  long steps_;
  ProgressBar bar_;
  std::filesystem::path log_;
  Stopwatch watch_;
  long unsolved_ = 0;
  double worst_ = 0;
  long tenths_ = 0;  // that are in the log
};

/// Appends text to run.log in the folder of a run. Throws FileError.
void append_to_log(const std::filesystem::path& folder, const std::string& text);

}  // namespace bipot
