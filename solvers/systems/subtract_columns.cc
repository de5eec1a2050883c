#include "solvers/systems/subtract_columns.h"

#include "solvers/systems/every_width.h"

namespace bipot {
BIPOT_EVERY_WIDTH void subtract_columns(double* __restrict x, const double* const* column,
                                        const double* weight, int count, int n) {
  int k = 0;
  for (; k + 8 <= count; k += 8, column += 8, weight += 8) {
    const double* const __restrict a = column[0], * const __restrict b = column[1], * const __restrict c = column[2], * const __restrict d = column[3], * const __restrict e = column[4], * const __restrict f = column[5], * const __restrict g = column[6], * const __restrict h = column[7];
    const double wa = weight[0], wb = weight[1], wc = weight[2], wd = weight[3], we = weight[4],
                 wf = weight[5], wg = weight[6], wh = weight[7];
    for (int i = 0; i < n; ++i) {
      double sum = x[i];
      sum -= wa * a[i];
      sum -= wb * b[i];
      sum -= wc * c[i];
      sum -= wd * d[i];
      sum -= we * e[i];
      sum -= wf * f[i];
      sum -= wg * g[i];
      sum -= wh * h[i];
      x[i] = sum;
    }
  }
  for (; k + 2 <= count; k += 2, column += 2, weight += 2) {
    const double* const __restrict a = column[0], * const __restrict b = column[1];
    const double wa = weight[0], wb = weight[1];
    for (int i = 0; i < n; ++i) {
      double sum = x[i];
      sum -= wa * a[i];
      sum -= wb * b[i];
      x[i] = sum;
    }
  }
  for (; k < count; ++k, ++column, ++weight) {
    const double* const __restrict a = column[0];
    const double wa = weight[0];
    for (int i = 0; i < n; ++i) x[i] -= wa * a[i];
  }
}

}  // namespace bipot
