#pragma once

#include <cstddef>

namespace bipot {

/// Right sides that the substitution of frontal_lu.h takes at once: each number of the factor is read
/// once for all of them, and meets as many numbers as a register of 512 bits holds.
inline constexpr int kRightSides = 8;

/// The loops of that substitution, compiled for several instruction sets; the machine decides when
/// the program starts. A right side's numbers stand kRightSides apart: y is rows of so many. Sums
/// have one order in all of them, and no right side sees another.

/// out_i -= sum_j x(i, j) y_j, i < n, j < count; columns of x are `stride` apart.
void subtract_columns_of_eight(int n, int count, const double* x, std::ptrdiff_t stride,
                               const double* y, double* out);
/// out_j -= sum_i x(i, j) y_i, j < count, i < n.
void subtract_products_of_eight(int n, int count, const double* x, std::ptrdiff_t stride,
                                const double* y, double* out);
/// y = L⁻¹ y, y = U⁻¹ y with the triangles of frontal_kernels.h.
void solve_unit_lower_of_eight(int n, const double* x, std::ptrdiff_t stride, double* y);
void solve_upper_of_eight(int n, const double* x, std::ptrdiff_t stride, double* y);

}  // namespace bipot
