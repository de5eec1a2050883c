#pragma once

#include "core/base/types.h"

namespace bipot {

/// The pattern of W (d m x d m, may be unsymmetric), made symmetric and of whole d x d blocks,
/// including those of the diagonal; values 0. It is the pattern that a multifrontal factorisation
/// (frontal_lu.h) needs, for a matrix whose rows and columns are those of contacts.
SparseMatrix symmetric_block_pattern(const Eigen::Ref<const SparseMatrix>& W, int d);

/// Position of the entry (row, col) among the values of a compressed matrix; its pattern must have
/// it.
int value_position(const SparseMatrix& matrix, int row, int col);

}  // namespace bipot
