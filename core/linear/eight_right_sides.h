#pragma once

#include <cstddef>

namespace bipot {

/// Number of right-hand sides that the substitution of frontal_lu.h processes at once. Each number
/// of the factor is read once for all of them; eight fill a register of 512 bits.
inline constexpr int kRightSides = 8;

/// The loops of that substitution, compiled for several instruction sets, chosen at program start.
/// y has kRightSides numbers in each row. All instruction sets sum in the same order. Right-hand
/// sides do not affect each other.

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
