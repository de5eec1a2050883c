#include "core/linear/block_pattern.h"

#include <algorithm>
#include <vector>

#include "core/base/lists.h"

namespace bipot {

namespace {

/// Rows of each column, as in a compressed matrix.
using Columns = Lists<>;

/// The d x d blocks of W with an entry, each once, in no order.
Columns blocks_of(const Eigen::Ref<const SparseMatrix>& W, int d) {
  const int n = static_cast<int>(W.cols()) / d;
  Columns blocks;
  blocks.items.reserve(to_size(W.nonZeros()) / to_size(d));
  std::vector<int> seen(to_size(W.rows() / d), -1);
  for (int b = 0; b < n; ++b) {
    for (int j = b * d; j < (b + 1) * d; ++j) {
      for (Eigen::Ref<const SparseMatrix>::InnerIterator it(W, j); it; ++it) {
        const int a = static_cast<int>(it.row()) / d;
        if (seen[to_size(a)] == b) continue;
        seen[to_size(a)] = b;
        blocks.items.push_back(a);
      }
    }
    blocks.start.push_back(static_cast<int>(blocks.items.size()));
  }
  return blocks;
}

Columns transposed(const Columns& columns) {
  return make_lists(columns.count(), [&](const auto& put) {
    for (int b = 0; b < columns.count(); ++b) {
      for (const int a : columns.of(b)) put(a, b);
    }
  });
}

/// Union of both and the diagonal, rows ascending.
Columns united(const Columns& one, const Columns& other) {
  Columns all;
  all.items.reserve(one.items.size() + to_size(one.count()));
  std::vector<int> seen(to_size(one.count()), -1);
  for (int b = 0; b < one.count(); ++b) {
    const auto add = [&](int a) {
      if (seen[to_size(a)] == b) return;
      seen[to_size(a)] = b;
      all.items.push_back(a);
    };
    add(b);
    for (const Columns* part : {&one, &other}) {
      for (const int a : part->of(b)) add(a);
    }
    std::sort(all.items.begin() + all.start.back(), all.items.end());
    all.start.push_back(static_cast<int>(all.items.size()));
  }
  return all;
}

}  // namespace

SparseMatrix symmetric_block_pattern(const Eigen::Ref<const SparseMatrix>& W, int d) {
  const Columns own = blocks_of(W, d), blocks = united(own, transposed(own));
  SparseMatrix pattern(W.rows(), W.cols());
  pattern.resizeNonZeros(static_cast<Eigen::Index>(blocks.items.size()) * d * d);
  std::fill_n(pattern.valuePtr(), pattern.nonZeros(), 0.0);
  int* row = pattern.innerIndexPtr();
  for (int j = 0; j < W.cols(); ++j) {
    pattern.outerIndexPtr()[j] = static_cast<int>(row - pattern.innerIndexPtr());
    for (const int a : blocks.of(j / d)) {
      for (int i = 0; i < d; ++i) *row++ = a * d + i;
    }
  }
  pattern.outerIndexPtr()[W.cols()] = static_cast<int>(row - pattern.innerIndexPtr());
  return pattern;
}

int value_position(const SparseMatrix& matrix, int row, int col) {
  const int* begin = matrix.innerIndexPtr() + matrix.outerIndexPtr()[col];
  const int* end = matrix.innerIndexPtr() + matrix.outerIndexPtr()[col + 1];
  return static_cast<int>(std::lower_bound(begin, end, row) - matrix.innerIndexPtr());
}

}  // namespace bipot
