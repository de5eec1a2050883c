#include "core/problem/eight_right_sides.h"

#include <cstring>

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__)
#define BIPOT_CLONES __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define BIPOT_CLONES
#endif

namespace bipot {
namespace {

// One number of each right side in one variable, whatever width the machine's registers have.
using Eight [[gnu::vector_size(64)]] = double;
static_assert(sizeof(Eight) == kRightSides * sizeof(double));

[[gnu::always_inline]] inline Eight eight_at(const double* y, int row) {
  Eight eight;
  std::memcpy(&eight, y + row * kRightSides, sizeof eight);
  return eight;
}
[[gnu::always_inline]] inline void put(Eight eight, double* y, int row) {
  std::memcpy(y + row * kRightSides, &eight, sizeof eight);
}

/// out_i -= sum_j x[i down + j along] y_j, eight rows at once: as many chains of sums as hide each
/// other's latency.
[[gnu::always_inline]] inline void subtract_all(int rows, int count, const double* x,
                                                std::ptrdiff_t down, std::ptrdiff_t along,
                                                const double* y, double* __restrict out) {
  int i = 0;
  for (; i + 8 <= rows; i += 8) {
    Eight a = eight_at(out, i), b = eight_at(out, i + 1), c = eight_at(out, i + 2),
          d = eight_at(out, i + 3), e = eight_at(out, i + 4), f = eight_at(out, i + 5),
          g = eight_at(out, i + 6), h = eight_at(out, i + 7);
    const double* at = x + i * down;
    for (int j = 0; j < count; ++j, at += along) {
      const Eight by = eight_at(y, j);
      a -= at[0] * by;
      b -= at[down] * by;
      c -= at[2 * down] * by;
      d -= at[3 * down] * by;
      e -= at[4 * down] * by;
      f -= at[5 * down] * by;
      g -= at[6 * down] * by;
      h -= at[7 * down] * by;
    }
    put(a, out, i);
    put(b, out, i + 1);
    put(c, out, i + 2);
    put(d, out, i + 3);
    put(e, out, i + 4);
    put(f, out, i + 5);
    put(g, out, i + 6);
    put(h, out, i + 7);
  }
  for (; i + 2 <= rows; i += 2) {
    Eight a = eight_at(out, i), b = eight_at(out, i + 1);
    const double* at = x + i * down;
    for (int j = 0; j < count; ++j, at += along) {
      const Eight by = eight_at(y, j);
      a -= at[0] * by;
      b -= at[down] * by;
    }
    put(a, out, i);
    put(b, out, i + 1);
  }
  if (i < rows) {
    Eight a = eight_at(out, i);
    const double* at = x + i * down;
    for (int j = 0; j < count; ++j, at += along) a -= at[0] * eight_at(y, j);
    put(a, out, i);
  }
}

// Rows of a triangle between two products with all that is solved already.
constexpr int kBlock = 8;

}  // namespace

BIPOT_CLONES void subtract_columns_of_eight(int n, int count, const double* x,
                                            std::ptrdiff_t stride, const double* y, double* out) {
  subtract_all(n, count, x, 1, stride, y, out);
}

BIPOT_CLONES void subtract_products_of_eight(int n, int count, const double* x,
                                             std::ptrdiff_t stride, const double* y, double* out) {
  subtract_all(count, n, x, stride, 1, y, out);
}

BIPOT_CLONES void solve_unit_lower_of_eight(int n, const double* x, std::ptrdiff_t stride,
                                            double* y) {
  for (int begin = 0; begin < n; begin += kBlock) {
    const int end = begin + kBlock < n ? begin + kBlock : n;
    subtract_all(end - begin, begin, x + begin, 1, stride, y, y + begin * kRightSides);
    for (int j = begin; j + 1 < end; ++j) {
      const Eight by = eight_at(y, j);
      for (int i = j + 1; i < end; ++i) put(eight_at(y, i) - x[j * stride + i] * by, y, i);
    }
  }
}

BIPOT_CLONES void solve_upper_of_eight(int n, const double* x, std::ptrdiff_t stride, double* y) {
  for (int end = n; end > 0; end -= kBlock) {
    const int begin = end > kBlock ? end - kBlock : 0;
    subtract_all(end - begin, n - end, x + end * stride + begin, 1, stride, y + end * kRightSides,
                 y + begin * kRightSides);
    for (int j = end - 1; j >= begin; --j) {
      const Eight by = eight_at(y, j) * x[j * stride + j];
      put(by, y, j);
      for (int i = begin; i < j; ++i) put(eight_at(y, i) - x[j * stride + i] * by, y, i);
    }
  }
}

}  // namespace bipot
