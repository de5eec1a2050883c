#include "core/problem/frontal_kernels.h"

#include <cmath>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define BIPOT_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define BIPOT_CLONES
#endif

namespace bipot {
namespace {

template <class Real>
[[gnu::always_inline]] inline void subtract_all(int n, int count, const Real* a, const Real* x,
                                                std::ptrdiff_t stride, Real* __restrict y) {
  int j = 0;
  for (; j + 4 <= count; j += 4, x += 4 * stride) {
    const Real *p = x, *q = x + stride, *r = q + stride, *s = r + stride;
    const Real aj = a[j], bj = a[j + 1], cj = a[j + 2], dj = a[j + 3];
    for (int i = 0; i < n; ++i) y[i] -= (aj * p[i] + bj * q[i]) + (cj * r[i] + dj * s[i]);
  }
  for (; j < count; ++j, x += stride) {
    const Real aj = a[j];
    for (int i = 0; i < n; ++i) y[i] -= aj * x[i];
  }
}

constexpr int kSums = 8;

template <class Real>
[[gnu::always_inline]] inline Real sum_of(const Real* lane) {
  return ((lane[0] + lane[4]) + (lane[1] + lane[5])) + ((lane[2] + lane[6]) + (lane[3] + lane[7]));
}

template <class Real>
[[gnu::always_inline]] inline void subtract_dots(int n, int count, const Real* x,
                                                 std::ptrdiff_t stride, const Real* __restrict y,
                                                 Real* __restrict out) {
  const int whole = n - n % kSums;
  int j = 0;
  for (; j + 2 <= count; j += 2, x += 2 * stride) {
    const Real *p = x, *q = x + stride;
    Real a[kSums] = {}, b[kSums] = {};
    for (int i = 0; i < whole; i += kSums) {
      for (int k = 0; k < kSums; ++k) a[k] += p[i + k] * y[i + k];
      for (int k = 0; k < kSums; ++k) b[k] += q[i + k] * y[i + k];
    }
    for (int i = whole; i < n; ++i) {
      a[i - whole] += p[i] * y[i];
      b[i - whole] += q[i] * y[i];
    }
    out[j] -= sum_of(a);
    out[j + 1] -= sum_of(b);
  }
  for (; j < count; ++j, x += stride) {
    Real a[kSums] = {};
    for (int i = 0; i < whole; i += kSums) {
      for (int k = 0; k < kSums; ++k) a[k] += x[i + k] * y[i + k];
    }
    for (int i = whole; i < n; ++i) a[i - whole] += x[i] * y[i];
    out[j] -= sum_of(a);
  }
}

template <class Real>
[[gnu::always_inline]] inline Real largest_of(int n, const Real* x) {
  Real largest = 0, sum = 0;
  for (int i = 0; i < n; ++i) {
    const Real size = std::abs(x[i]);
    largest = size > largest ? size : largest;
    sum += x[i] - x[i];  // zero, or not a number where x is not finite
  }
  return largest + sum;
}

}  // namespace

BIPOT_CLONES void subtract_columns(int n, int count, const double* a, const double* x,
                                   std::ptrdiff_t stride, double* y) {
  subtract_all(n, count, a, x, stride, y);
}
BIPOT_CLONES void subtract_columns(int n, int count, const float* a, const float* x,
                                   std::ptrdiff_t stride, float* y) {
  subtract_all(n, count, a, x, stride, y);
}
BIPOT_CLONES void subtract_products(int n, int count, const double* x, std::ptrdiff_t stride,
                                    const double* y, double* out) {
  subtract_dots(n, count, x, stride, y, out);
}
BIPOT_CLONES void subtract_products(int n, int count, const float* x, std::ptrdiff_t stride,
                                    const float* y, float* out) {
  subtract_dots(n, count, x, stride, y, out);
}
BIPOT_CLONES double largest_size(int n, const double* x) { return largest_of(n, x); }
BIPOT_CLONES float largest_size(int n, const float* x) { return largest_of(n, x); }

}  // namespace bipot
