#pragma once

#include <deque>
#include <string>

namespace bipot {

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

/// As "about 12 s", "about 3 min", "about 2 h".
std::string about(double seconds);

}  // namespace bipot
