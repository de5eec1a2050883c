#pragma once

#include <algorithm>
#include <limits>

namespace bipot {

/// Stagnation test: true once the best error has not halved during max(least, k) iterations, where
/// k is the iteration at which it last did.
class StagnationTest {
 public:
  explicit StagnationTest(int least) : least_(least), iterations_(least) {}
  /// Records the best error so far. True if the iteration stagnates.
  bool stagnates(int iteration, double best_error) {
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
