#include "core/problem/block_pattern.h"

#include <algorithm>
#include <vector>

namespace bipot {

SparseMatrix symmetric_block_pattern(const Eigen::Ref<const SparseMatrix>& W, int d) {
  std::vector<Eigen::Triplet<double>> blocks;
  blocks.reserve(static_cast<std::size_t>(2 * W.nonZeros() + W.cols()));
  for (int j = 0; j < W.cols(); ++j) {
    if (j % d == 0) blocks.emplace_back(j / d, j / d, 0);
    for (Eigen::Ref<const SparseMatrix>::InnerIterator it(W, j); it; ++it) {
      const int a = static_cast<int>(it.row()) / d, b = j / d;
      if (a == b) continue;
      blocks.emplace_back(a, b, 0);
      blocks.emplace_back(b, a, 0);
    }
  }
  SparseMatrix graph(W.rows() / d, W.cols() / d);
  graph.setFromTriplets(blocks.begin(), blocks.end());
  SparseMatrix pattern(W.rows(), W.cols());
  pattern.reserve(graph.nonZeros() * d * d);
  for (int j = 0; j < W.cols(); ++j) {
    pattern.startVec(j);
    for (SparseMatrix::InnerIterator it(graph, j / d); it; ++it) {
      for (int k = 0; k < d; ++k) pattern.insertBack(it.row() * d + k, j) = 0;
    }
  }
  pattern.finalize();
  return pattern;
}

int value_position(const SparseMatrix& matrix, int row, int col) {
  const int* begin = matrix.innerIndexPtr() + matrix.outerIndexPtr()[col];
  const int* end = matrix.innerIndexPtr() + matrix.outerIndexPtr()[col + 1];
  return static_cast<int>(std::lower_bound(begin, end, row) - matrix.innerIndexPtr());
}

}  // namespace bipot
