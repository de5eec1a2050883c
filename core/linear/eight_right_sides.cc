#include "core/linear/eight_right_sides.h"

#include <cstring>

#include "core/base/instruction_sets.h"

namespace bipot {
namespace {

// One number of each right-hand side in one variable, for any width of the machine's registers.
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

/// out_i -= sum_j x[i down + j along] y_j for kRows rows, all sums in registers. With few rows each
/// has two sums, so that products are independent.
template <int kRows>
[[gnu::always_inline]] inline void subtract_rows(int count, const double* x, std::ptrdiff_t down,
                                                 std::ptrdiff_t along, const double* y,
                                                 double* __restrict out) {
  Eight sum[std::size_t{kRows}], other[std::size_t{kRows}];
  for (int k = 0; k < kRows; ++k) {
    sum[k] = eight_at(out, k);
    other[k] = Eight{};
  }
  int j = 0;
  if (kRows < 4) {
    for (; j + 2 <= count; j += 2, x += 2 * along) {
      const Eight by = eight_at(y, j), next = eight_at(y, j + 1);
      for (int k = 0; k < kRows; ++k) {
        sum[k] -= x[k * down] * by;
        other[k] -= x[k * down + along] * next;
      }
    }
  }
  for (; j < count; ++j, x += along) {
    const Eight by = eight_at(y, j);
    for (int k = 0; k < kRows; ++k) sum[k] -= x[k * down] * by;
  }
  for (int k = 0; k < kRows; ++k) put(kRows < 4 ? sum[k] + other[k] : sum[k], out, k);
}

/// The same for any number of rows, four at once: their sums fit into the registers of AVX2 and
/// hide the latency.
[[gnu::always_inline]] inline void subtract_all(int rows, int count, const double* x,
                                                std::ptrdiff_t down, std::ptrdiff_t along,
                                                const double* y, double* __restrict out) {
  for (; rows >= 4; rows -= 4, x += 4 * down, out += 4 * kRightSides) {
    subtract_rows<4>(count, x, down, along, y, out);
  }
  if (rows == 3) subtract_rows<3>(count, x, down, along, y, out);
  if (rows == 2) subtract_rows<2>(count, x, down, along, y, out);
  if (rows == 1) subtract_rows<1>(count, x, down, along, y, out);
}

// Rows of a triangle between two products with the solved part.
constexpr int kBlock = 4;

/// Solves a block of the unit lower or the upper triangle, in registers if it is whole.
template <int kCount>
[[gnu::always_inline]] inline void solve_lower_block(const double* x, std::ptrdiff_t stride,
                                                     double* y) {
  Eight row[std::size_t{kCount}];
  for (int i = 0; i < kCount; ++i) row[i] = eight_at(y, i);
  for (int j = 0; j < kCount; ++j) {
    for (int i = j + 1; i < kCount; ++i) row[i] -= x[j * stride + i] * row[j];
  }
  for (int i = 1; i < kCount; ++i) put(row[i], y, i);
}
template <int kCount>
[[gnu::always_inline]] inline void solve_upper_block(const double* x, std::ptrdiff_t stride,
                                                     double* y) {
  Eight row[std::size_t{kCount}];
  for (int i = 0; i < kCount; ++i) row[i] = eight_at(y, i);
  for (int j = kCount - 1; j >= 0; --j) {
    row[j] = row[j] * x[j * stride + j];
    for (int i = 0; i < j; ++i) row[i] -= x[j * stride + i] * row[j];
  }
  for (int i = 0; i < kCount; ++i) put(row[i], y, i);
}

}  // namespace

BIPOT_EVERY_LEVEL void subtract_columns_of_eight(int n, int count, const double* x,
                                                 std::ptrdiff_t stride, const double* y,
                                                 double* out) {
  subtract_all(n, count, x, 1, stride, y, out);
}

BIPOT_EVERY_LEVEL void subtract_products_of_eight(int n, int count, const double* x,
                                                  std::ptrdiff_t stride, const double* y,
                                                  double* out) {
  subtract_all(count, n, x, stride, 1, y, out);
}

BIPOT_EVERY_LEVEL void solve_unit_lower_of_eight(int n, const double* x, std::ptrdiff_t stride,
                                                 double* y) {
  for (int begin = 0; begin < n; begin += kBlock) {
    const int count = n - begin < kBlock ? n - begin : kBlock;
    double* const rows = y + begin * kRightSides;
    const double* const block = x + begin * stride + begin;
    subtract_all(count, begin, x + begin, 1, stride, y, rows);
    if (count == 4) solve_lower_block<4>(block, stride, rows);
    if (count == 3) solve_lower_block<3>(block, stride, rows);
    if (count == 2) solve_lower_block<2>(block, stride, rows);
  }
}

BIPOT_EVERY_LEVEL void solve_upper_of_eight(int n, const double* x, std::ptrdiff_t stride,
                                            double* y) {
  for (int end = n; end > 0; end -= kBlock) {
    const int begin = end > kBlock ? end - kBlock : 0, count = end - begin;
    double* const rows = y + begin * kRightSides;
    const double* const block = x + begin * stride + begin;
    if (end < n) {
      subtract_all(count, n - end, x + end * stride + begin, 1, stride, y + end * kRightSides,
                   rows);
    }
    if (count == 4) solve_upper_block<4>(block, stride, rows);
    if (count == 3) solve_upper_block<3>(block, stride, rows);
    if (count == 2) solve_upper_block<2>(block, stride, rows);
    if (count == 1) solve_upper_block<1>(block, stride, rows);
  }
}

}  // namespace bipot
