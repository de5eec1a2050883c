#pragma once

#include <cstddef>

namespace bipot {

/// The vector loops of the multifrontal factorisation (frontal_lu.h), compiled for several
/// instruction sets, chosen at program start. All sum in the same order.

/// y -= sum_j a[j] x_j, j < count; x_j are the columns of x, `stride` apart, of n numbers.
void subtract_columns(int n, int count, const double* a, const double* x, std::ptrdiff_t stride,
                      double* y);

/// out[j] -= x_j · y, j < count.
void subtract_products(int n, int count, const double* x, std::ptrdiff_t stride, const double* y,
                       double* out);

/// y = L⁻¹ y, y = U⁻¹ y: the unit lower and the upper triangle of the n columns of x, `stride`
/// apart. The diagonal holds the inverses of that of U. Four columns at once shorten the dependency
/// chain.
void solve_unit_lower(int n, const double* x, std::ptrdiff_t stride, double* y);
void solve_upper(int n, const double* x, std::ptrdiff_t stride, double* y);

/// x *= factor. Returns max |x_i| of the products; NaN if one is not finite.
double scale_column(int n, double factor, double* x);

}  // namespace bipot
