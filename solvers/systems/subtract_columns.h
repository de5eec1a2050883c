#pragma once

namespace bipot {

/// x -= weight[0] column[0] + weight[1] column[1] + ..., for `count` columns of n entries. Each
/// entry subtracts one after the other. Hence vectors of two, four or eight lanes give the same
/// bits, and the widest of the machine are used. 16 flops for each load and store of x.
void subtract_columns(double* x, const double* const* column, const double* weight, int count,
                      int n);

}  // namespace bipot
