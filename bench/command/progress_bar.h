#pragma once

#include <deque>
#include <string>

#include "core/base/stopwatch.h"

namespace bipot {

/// As "about 12 s", "about 3 min", "about 2 h".
std::string about(double seconds);

/// Progress on standard error. On a terminal one line, as wide as it, redrawn at most ten times a
/// second. Elsewhere, as in a batch job, a line each 10 %, but none in the first second. (Debian 12
/// packages no C++ progress-bar library.)
class ProgressBar {
 public:
  /// The time that the rest of a task needs, by the trend of its recent cost: a packing that grows
  /// makes each step dearer.
  class RemainingTime {
   public:
    explicit RemainingTime(long total) : total_(total) {}

    /// `done` parts of the total are finished after these seconds; both grow.
    void add(long done, double seconds);
    /// The cost of the last fifth of the total goes on to grow or fall as it did there, to between
    /// half and twice its mean.                                                                [s]
    double seconds() const;

   private:
    struct Mark {
      long done;
      double seconds;
    };
    long total_;
    std::deque<Mark> marks_{{0, 0.0}};
  };
  ProgressBar(long total, bool quiet);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// `done` of total are finished; `note` follows the bar, as far as there is room.
  void update(long done, const std::string& note);
  /// Lines of their own, above the bar.
  void say(const std::string& lines);

 private:
  long total_;
  bool quiet_, terminal_;
  Stopwatch watch_;
  RemainingTime remaining_;
  double drawn_ = -1;  // when, in seconds
  long tenths_ = 0;    // that lines were written for
};

/// The line of a progress bar on a terminal with so many columns; without a time where it is NaN.
std::string progress_line(long done, long total, double seconds_left, const std::string& note,
                          int columns);

}  // namespace bipot
