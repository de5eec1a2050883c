#pragma once

namespace bipot {

/// x -= weight[0] column[0] + weight[1] column[1] + ..., `count` columns of n entries, subtracted one
/// after the other in each entry: the same bits with vectors of any width, two, four or eight
/// lanes, of which the machine's widest run. 16 flops a load and store of x.
void subtract_columns(double* x, const double* const* column, const double* weight, int count,
                      int n);
void subtract_columns(double* x, const float* const* column, const double* weight, int count,
                      int n);

}  // namespace bipot
