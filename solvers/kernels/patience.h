#pragma once

#include <algorithm>
#include <limits>

namespace bipot {

/// With what an iteration does, until it has not halved the best error for as many iterations as it
/// took to get there, and at least `least`.
class Patience {
 public:
  explicit Patience(int least) : least_(least), iterations_(least) {}
  /// Tells the best error so far. True where patience is lost: something else begins now.
  bool lost(int iteration, double best_error) {
    if (best_error <= 0.5 * mark_) {
      mark_ = best_error;
      mark_iteration_ = iteration;
      iterations_ = std::max(least_, iteration);
    } else if (iteration - mark_iteration_ > iterations_) {
      mark_iteration_ = iteration;
      iterations_ = std::max(least_, iteration / 2);
      return true;
    }
    return false;
  }

 private:
  int least_;
  double mark_ = std::numeric_limits<double>::infinity();
  int mark_iteration_ = 0, iterations_;
};

}  // namespace bipot
