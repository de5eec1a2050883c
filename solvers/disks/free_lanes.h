#pragma once

#include <vector>

#include "core/base/execution.h"
#include "core/base/types.h"

namespace bipot {

/// Least distance of two batches with the same body: the kernels process two at once.
inline constexpr int kBatchGap = 2;

/// Batches of kLanes in the course of filling.
class FreeLanes {
 public:
  void clear() {
    lanes_.clear();
    count_.clear();
    skip_.clear();
  }
  /// First batch from `batch` on with a free lane, perhaps a new one (union-find with path
  /// halving).
  int first(int batch) {
    while (batch < size() && skip_[to_size(batch)] != batch) {
      int& next = skip_[to_size(batch)];
      if (next < size()) next = skip_[to_size(next)];
      batch = next;
    }
    return batch;
  }
  void put(int batch, int contact) {
    while (batch >= size()) {
      skip_.push_back(size());
      count_.push_back(0);
      lanes_.resize(lanes_.size() + kLanes, -1);
    }
    int& count = count_[to_size(batch)];
    lanes_[to_size(batch * kLanes + count++)] = contact;
    if (count == kLanes) skip_[to_size(batch)] = batch + 1;
  }
  /// The contact in each lane, -1 if there is none.
  const std::vector<int>& lanes() const { return lanes_; }

 private:
  int size() const { return static_cast<int>(count_.size()); }

  std::vector<int> lanes_, count_;  // contacts of each batch
  std::vector<int> skip_;           // the batch itself while it has a free lane, else a later one
};

}  // namespace bipot
