#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

#include "core/base/types.h"

namespace bipot {

/// Disjoint sets of 0 ... n - 1; the smallest member stands for its set.
class DisjointSets {
 public:
  explicit DisjointSets(int n) : parent_(to_size(n)) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int find(int k) {
    while (parent_[to_size(k)] != k) {
      k = parent_[to_size(k)] = parent_[to_size(parent_[to_size(k)])];
    }
    return k;
  }
  void unite(int a, int b) {
    a = find(a);
    b = find(b);
    parent_[to_size(std::max(a, b))] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

}  // namespace bipot
