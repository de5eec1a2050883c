#include "core/linear/block_pattern.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace bipot {

namespace {

/// Rows of each column, as in a compressed matrix.
struct Columns {
  std::vector<int> start{0}, row;

  int count() const { return static_cast<int>(start.size()) - 1; }
};

/// The d x d blocks of W with an entry, each once, in no order.
Columns blocks_of(const Eigen::Ref<const SparseMatrix>& W, int d) {
  const int n = static_cast<int>(W.cols()) / d;
  Columns blocks;
  blocks.row.reserve(to_size(W.nonZeros()) / to_size(d));
  std::vector<int> seen(to_size(W.rows() / d), -1);
  for (int b = 0; b < n; ++b) {
    for (int j = b * d; j < (b + 1) * d; ++j) {
      for (Eigen::Ref<const SparseMatrix>::InnerIterator it(W, j); it; ++it) {
        const int a = static_cast<int>(it.row()) / d;
        if (seen[to_size(a)] == b) continue;
        seen[to_size(a)] = b;
        blocks.row.push_back(a);
      }
    }
    blocks.start.push_back(static_cast<int>(blocks.row.size()));
  }
  return blocks;
}

Columns transposed(const Columns& columns) {
  Columns rows;
  rows.start.assign(columns.start.size(), 0);
  rows.row.resize(columns.row.size());
  for (const int a : columns.row) ++rows.start[to_size(a) + 1];
  std::partial_sum(rows.start.begin(), rows.start.end(), rows.start.begin());
  std::vector<int> next(rows.start.begin(), rows.start.end() - 1);
  for (int b = 0; b < columns.count(); ++b) {
    for (int k = columns.start[to_size(b)]; k < columns.start[to_size(b) + 1]; ++k) {
      rows.row[to_size(next[to_size(columns.row[to_size(k)])]++)] = b;
    }
  }
  return rows;
}

/// Union of both and the diagonal, rows ascending.
Columns united(const Columns& one, const Columns& other) {
  Columns all;
  all.row.reserve(one.row.size() + to_size(one.count()));
  std::vector<int> seen(to_size(one.count()), -1);
  for (int b = 0; b < one.count(); ++b) {
    const auto add = [&](int a) {
      if (seen[to_size(a)] == b) return;
      seen[to_size(a)] = b;
      all.row.push_back(a);
    };
    add(b);
    for (const Columns* part : {&one, &other}) {
      for (int k = part->start[to_size(b)]; k < part->start[to_size(b) + 1]; ++k) {
        add(part->row[to_size(k)]);
      }
    }
    std::sort(all.row.begin() + all.start.back(), all.row.end());
    all.start.push_back(static_cast<int>(all.row.size()));
  }
  return all;
}

}  // namespace

SparseMatrix symmetric_block_pattern(const Eigen::Ref<const SparseMatrix>& W, int d) {
  const Columns own = blocks_of(W, d), blocks = united(own, transposed(own));
  SparseMatrix pattern(W.rows(), W.cols());
  pattern.resizeNonZeros(static_cast<Eigen::Index>(blocks.row.size()) * d * d);
  std::fill_n(pattern.valuePtr(), pattern.nonZeros(), 0.0);
  int* row = pattern.innerIndexPtr();
  for (int j = 0; j < W.cols(); ++j) {
    pattern.outerIndexPtr()[j] = static_cast<int>(row - pattern.innerIndexPtr());
    for (int k = blocks.start[to_size(j / d)]; k < blocks.start[to_size(j / d) + 1]; ++k) {
      for (int i = 0; i < d; ++i) *row++ = blocks.row[to_size(k)] * d + i;
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
