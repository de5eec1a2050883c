#pragma once

#include <functional>
#include <stdexcept>
#include <utility>

namespace bipot {

/// What a factorisation throws that was asked to stop.
struct FactorStopped : std::runtime_error {
  FactorStopped() : std::runtime_error("a factorisation was stopped") {}
};

/// Lets a long factorisation stop before its end, for Ctrl-C and time limits.
class FactorStop {
 public:
  FactorStop() = default;
  /// `asked`: true if the factorisation is to stop; it may be empty.
  explicit FactorStop(std::function<bool()> asked) : asked_(std::move(asked)) {}

  /// Throws FactorStopped if it is to stop.
  void ask() {
    operations_ = 0;
    if (asked_ && asked_()) throw FactorStopped();
  }
  /// The same after every kInterval operations.
  void count(double operations) {
    operations_ += operations;
    if (operations_ >= kInterval) ask();
  }
  /// Columns of a product, of n in all, that may be computed at once: multiples of 64, unless all
  /// may be. `operations`: for one of them.
  static int columns_at_once(double operations, int n) {
    if (operations * n <= kInterval) return n;
    return 64 * (1 + static_cast<int>(kInterval / 64 / operations));
  }

 private:
  static constexpr double kInterval = 3e8;  // about 0.1 s

  std::function<bool()> asked_;
  double operations_ = 0;  // since it asked
};

}  // namespace bipot
