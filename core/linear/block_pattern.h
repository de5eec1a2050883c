#pragma once

#include "core/base/types.h"

namespace bipot {

/// The pattern of W (d m x d m, also unsymmetric) made symmetric and of whole d x d blocks, the
/// blocks of the diagonal included; values 0. What a factorisation by fronts (frontal_lu.h) asks of
/// a matrix whose rows and columns are those of contacts.
SparseMatrix symmetric_block_pattern(const Eigen::Ref<const SparseMatrix>& W, int d);

/// Where the values of a compressed matrix hold its entry (row, col), which its pattern must have.
int value_position(const SparseMatrix& matrix, int row, int col);

}  // namespace bipot
