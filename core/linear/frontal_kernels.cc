#include "core/linear/frontal_kernels.h"

#include <cmath>
#include <cstring>

#include "core/base/instruction_sets.h"

namespace bipot {
namespace {

[[gnu::always_inline]] inline void subtract_all(int n, int count, const double* a, const double* x,
                                                std::ptrdiff_t stride, double* __restrict y) {
  int j = 0;
  for (; j + 4 <= count; j += 4, x += 4 * stride) {
    const double *p = x, *q = x + stride, *r = q + stride, *s = r + stride;
    const double aj = a[j], bj = a[j + 1], cj = a[j + 2], dj = a[j + 3];
    for (int i = 0; i < n; ++i) y[i] -= (aj * p[i] + bj * q[i]) + (cj * r[i] + dj * s[i]);
  }
  for (; j < count; ++j, x += stride) {
    const double aj = a[j];
    for (int i = 0; i < n; ++i) y[i] -= aj * x[i];
  }
}

// Four numbers in one variable, for any width of the machine's registers.
using Four [[gnu::vector_size(32)]] = double;

[[gnu::always_inline]] inline Four four_at(const double* x) {
  Four four;
  std::memcpy(&four, x, sizeof four);
  return four;
}

[[gnu::always_inline]] inline double sum_of(const Four& lane, double rest) {
  return ((lane[0] + lane[2]) + (lane[1] + lane[3])) + rest;
}

[[gnu::always_inline]] inline void subtract_dots(int n, int count, const double* x,
                                                 std::ptrdiff_t stride, const double* __restrict y,
                                                 double* __restrict out) {
  int j = 0;
  for (; j + 4 <= count; j += 4, x += 4 * stride) {
    const double *p = x, *q = x + stride, *r = q + stride, *s = r + stride;
    Four a{}, b{}, c{}, d{};
    double rest[4] = {};
    int i = 0;
    for (; i + 4 <= n; i += 4) {
      const Four at = four_at(y + i);
      a += four_at(p + i) * at;
      b += four_at(q + i) * at;
      c += four_at(r + i) * at;
      d += four_at(s + i) * at;
    }
    for (; i < n; ++i) {
      rest[0] += p[i] * y[i];
      rest[1] += q[i] * y[i];
      rest[2] += r[i] * y[i];
      rest[3] += s[i] * y[i];
    }
    out[j] -= sum_of(a, rest[0]);
    out[j + 1] -= sum_of(b, rest[1]);
    out[j + 2] -= sum_of(c, rest[2]);
    out[j + 3] -= sum_of(d, rest[3]);
  }
  for (; j < count; ++j, x += stride) {
    Four a{};
    double rest = 0;
    int i = 0;
    for (; i + 4 <= n; i += 4) a += four_at(x + i) * four_at(y + i);
    for (; i < n; ++i) rest += x[i] * y[i];
    out[j] -= sum_of(a, rest);
  }
}

[[gnu::always_inline]] inline void solve_lower_unit(int n, const double* x, std::ptrdiff_t stride,
                                                    double* __restrict y) {
  int j = 0;
  for (; j + 4 <= n; j += 4, x += 4 * stride) {
    const double *p = x, *q = x + stride, *r = q + stride, *s = r + stride;
    const double a = y[j], b = y[j + 1] - a * p[j + 1];
    const double c = y[j + 2] - (a * p[j + 2] + b * q[j + 2]);
    const double d = y[j + 3] - (a * p[j + 3] + b * q[j + 3] + c * r[j + 3]);
    y[j + 1] = b;
    y[j + 2] = c;
    y[j + 3] = d;
    for (int i = j + 4; i < n; ++i) y[i] -= (a * p[i] + b * q[i]) + (c * r[i] + d * s[i]);
  }
  for (; j + 1 < n; ++j, x += stride) {
    const double factor = y[j];
    for (int i = j + 1; i < n; ++i) y[i] -= factor * x[i];
  }
}

[[gnu::always_inline]] inline void solve_upper_columns(int n, const double* x,
                                                       std::ptrdiff_t stride,
                                                       double* __restrict y) {
  int j = n - 1;
  for (; j >= 3; j -= 4) {
    const double *s = x + j * stride, *r = s - stride, *q = r - stride, *p = q - stride;
    const double d = y[j] * s[j], c = (y[j - 1] - d * s[j - 1]) * r[j - 1];
    const double b = (y[j - 2] - (d * s[j - 2] + c * r[j - 2])) * q[j - 2];
    const double a = (y[j - 3] - (d * s[j - 3] + c * r[j - 3] + b * q[j - 3])) * p[j - 3];
    y[j] = d;
    y[j - 1] = c;
    y[j - 2] = b;
    y[j - 3] = a;
    for (int i = 0; i < j - 3; ++i) y[i] -= (d * s[i] + c * r[i]) + (b * q[i] + a * p[i]);
  }
  for (; j >= 0; --j) {
    const double* const column = x + j * stride;
    const double factor = y[j] * column[j];
    y[j] = factor;
    for (int i = 0; i < j; ++i) y[i] -= factor * column[i];
  }
}

[[gnu::always_inline]] inline double scale_all(int n, double factor, double* x) {
  double largest = 0, sum = 0;
  for (int i = 0; i < n; ++i) {
    x[i] *= factor;
    const double size = std::abs(x[i]);
    largest = size > largest ? size : largest;
    sum += x[i] - x[i];  // zero, or NaN if x is not finite
  }
  return largest + sum;
}

}  // namespace

BIPOT_EVERY_LEVEL void subtract_columns(int n, int count, const double* a, const double* x,
                                        std::ptrdiff_t stride, double* y) {
  subtract_all(n, count, a, x, stride, y);
}
BIPOT_EVERY_LEVEL void subtract_products(int n, int count, const double* x, std::ptrdiff_t stride,
                                         const double* y, double* out) {
  subtract_dots(n, count, x, stride, y, out);
}
BIPOT_EVERY_LEVEL void solve_unit_lower(int n, const double* x, std::ptrdiff_t stride, double* y) {
  solve_lower_unit(n, x, stride, y);
}
BIPOT_EVERY_LEVEL void solve_upper(int n, const double* x, std::ptrdiff_t stride, double* y) {
  solve_upper_columns(n, x, stride, y);
}
BIPOT_EVERY_LEVEL double scale_column(int n, double factor, double* x) {
  return scale_all(n, factor, x);
}

}  // namespace bipot
