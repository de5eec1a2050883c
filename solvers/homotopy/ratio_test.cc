#include "solvers/homotopy/ratio_test.h"

#include <cstring>

#include "core/base/instruction_sets.h"

namespace bipot {
namespace {

// Four numbers in one variable, for any width of the machine's registers.
using Numbers [[gnu::vector_size(32)]] = double;

[[gnu::always_inline]] inline Numbers numbers_at(const double* x) {
  Numbers numbers;
  std::memcpy(&numbers, x, sizeof numbers);
  return numbers;
}

/// A parameter is nearer if speed > 0 and step speed > distance: if the smaller of speed and step
/// speed - distance is positive. Infinite steps of a speed of 0 give NaN and are skipped.
template <class Real>
[[gnu::always_inline]] inline Real excess(Real bound, Real value, Real x, Real direction, Real step,
                                          Real zero) {
  const Real speed = bound * x * direction, distance = bound * value;
  const Real left = step * speed - (distance > zero ? distance : zero);
  return left < speed ? left : speed;
}

}  // namespace

BIPOT_CLONES("avx512f", "avx2", "default")
bool any_nearer(const double* bound, const double* value, const double* x, double direction,
                double step, int n) {
  const Numbers zero{}, directions = zero + direction, steps = zero + step;
  Numbers most{};
  int k = 0;
  for (; k + 4 <= n; k += 4) {
    const Numbers left = excess<Numbers>(numbers_at(bound + k), numbers_at(value + k),
                                         numbers_at(x + k), directions, steps, zero);
    most = most < left ? left : most;
  }
  bool nearer = most[0] > 0 || most[1] > 0 || most[2] > 0 || most[3] > 0;
  for (; k < n; ++k) nearer |= excess<double>(bound[k], value[k], x[k], direction, step, 0) > 0;
  return nearer;
}

}  // namespace bipot
