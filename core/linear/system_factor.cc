#include "core/linear/system_factor.h"

namespace bipot {
namespace {

// Limit for a multifrontal factor. Its backward error is rounding times this or less, which the
// caller's iterative refinement reduces.
constexpr double kLargestFrontMultiplier = 1e8;

}  // namespace

bool LocalFactor::factor(const SparseMatrix& A) {
  by_fronts_ = fronts_.factor(A) && fronts_.largest_multiplier() <= kLargestFrontMultiplier;
  if (by_fronts_) return true;
  stop_.ask();
  return lu_.factor(A);
}

void LocalFactor::solve(const Vector& b, Vector& x) {
  if (by_fronts_) {
    fronts_.solve(b, x);
  } else {
    x = lu_.solve(b);
  }
}

int LocalFactor::determinant_sign() const {
  return by_fronts_ ? fronts_.determinant_sign() : lu_.determinant_sign();
}

}  // namespace bipot
