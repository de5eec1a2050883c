#pragma once

#include <atomic>
#include <cmath>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>

#include "bench/command/progress_bar.h"
#include "core/motion/time_stepping.h"
#include "solvers/solver.h"

namespace bipot {

/// Progress of a run: on standard error, and a line each 10 % in the file run.log of its folder.
/// Both tell of a step that takes long, at times that double.
class RunProgress {
 public:
  struct Options {
    bool quiet = false;
    std::filesystem::path folder;  ///< empty: no log
    bool resume = false;           ///< goes on in its own folder: appends to its log
    int step = 0;                  ///< steps before this run, which end at
    double time = 0;               ///<                                                       [s]
    double tol = 0;
    std::string hint;      ///< what helps against long steps
    double patience = 10;  ///< a step that takes so long is told                             [s]
  };
  /// Throws FileError if the log cannot be written.
  RunProgress(long steps, Options options);
  ~RunProgress();
  RunProgress(const RunProgress&) = delete;
  RunProgress& operator=(const RunProgress&) = delete;

  /// `done`: steps of this run; `time` at its end.                                            [s]
  template <int D>
  void add(const StepReport<D>& report, long done, double time);
  /// The solver of the present step is there. Stages of `auto` begin anew: the best counts, until
  /// the count of a new solve begins.
  void judged(const IterationRecord& record) {
    const double error = record.error.guarded();
    error_ = record.iteration > iteration_ ? std::fmin(error_, error) : error;
    iteration_ = record.iteration;
  }

 private:
  void look_at_the_step();

  long steps_;
  Options options_;
  ProgressBar bar_;
  std::filesystem::path log_;
  Stopwatch watch_;
  double step_began_ = 0, tell_after_;  // in seconds
  std::atomic<double> error_ = kNaN;    // of the present step's last solve, the best
  int iteration_ = 0;                   // of it, the last that was judged
  long done_ = 0;
  bool over_ = false;
  std::mutex mutex_;
  std::condition_variable end_;
  std::thread observer_;
  long unsolved_ = 0;
  double worst_ = 0;
  long tenths_ = 0;  // that are in the log
};

/// Appends text to run.log in the folder of a run. Throws FileError.
void append_to_log(const std::filesystem::path& folder, const std::string& text);

}  // namespace bipot
