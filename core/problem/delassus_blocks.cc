#include "core/problem/delassus_blocks.h"

#include <algorithm>

namespace bipot {

DelassusBlocks::DelassusBlocks(const SparseRows& W, int dim) : dim_(dim) {
  dispatch_count(dim, [&](auto d) { fill<d()>(W); });
}

template <int D>
void DelassusBlocks::fill(const SparseRows& W) {
  const int contacts = static_cast<int>(W.rows()) / D;
  start_.reserve(to_size(contacts) + 1);
  start_.push_back(0);
  neighbour_.reserve(to_size(W.nonZeros() / (D * D)));
  block_.reserve(to_size(W.nonZeros()));
  std::vector<int> missing;  // in the first row
  for (int c = 0; c < contacts; ++c) {
    const std::size_t first = neighbour_.size();
    missing.clear();
    for (int row = c * D; row < (c + 1) * D; ++row) {
      std::size_t k = first;
      for (SparseRows::InnerIterator it(W, row); it; ++it) {
        const int other = static_cast<int>(it.col()) / D;
        while (k < neighbour_.size() && neighbour_[k] < other) ++k;
        if (k < neighbour_.size() && neighbour_[k] == other) continue;
        (row == c * D ? neighbour_ : missing).push_back(other);
      }
    }
    if (!missing.empty()) {
      neighbour_.insert(neighbour_.end(), missing.begin(), missing.end());
      const auto own = neighbour_.begin() + static_cast<std::ptrdiff_t>(first);
      std::sort(own, neighbour_.end());
      neighbour_.erase(std::unique(own, neighbour_.end()), neighbour_.end());
    }
    block_.resize(neighbour_.size() * (D * D), 0.0);
    for (int a = 0; a < D; ++a) {
      std::size_t k = first;
      for (SparseRows::InnerIterator it(W, c * D + a); it; ++it) {
        const int other = static_cast<int>(it.col()) / D;
        while (neighbour_[k] != other) ++k;
        block_[k * (D * D) + to_size(a * D + static_cast<int>(it.col()) % D)] += it.value();
      }
    }
    start_.push_back(static_cast<int>(neighbour_.size()));
  }
}

void DelassusBlocks::apply(const Eigen::Ref<const Vector>& s, Vector& u) const {
  u.resize(s.size());
  dispatch_count(dim_, [&](auto d) {
    constexpr int D = d();
    for (int c = 0; c * D < static_cast<int>(s.size()); ++c) {
      u.segment<D>(c * D) = product<D>(c, s.data());
    }
  });
}

}  // namespace bipot
