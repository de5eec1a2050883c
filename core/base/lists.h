#pragma once

#include <numeric>
#include <span>
#include <vector>

#include "core/base/types.h"

namespace bipot {

/// Lists of items, one after the other: those of list k are items[start[k] .. start[k + 1] - 1].
template <class Item = int>
struct Lists {
  std::vector<int> start{0};  ///< of each list, and the end
  std::vector<Item> items = {};

  int count() const { return static_cast<int>(start.size()) - 1; }
  std::span<const Item> of(int k) const { return cut(items.data(), k); }
  std::span<Item> of(int k) { return cut(items.data(), k); }

 private:
  template <class Value>
  std::span<Value> cut(Value* first, int k) const {
    return {first + start[to_size(k)], first + start[to_size(k) + 1]};
  }
};

/// The lists of what `each` gives: each(put) calls put(list, item) for all items. It is called
/// twice, for their numbers and for the items, and must do the same both times.
template <class Item = int, class Each>
Lists<Item> make_lists(int count, const Each& each) {
  Lists<Item> lists;
  lists.start.assign(to_size(count) + 1, 0);
  each([&](int list, const Item&) { ++lists.start[to_size(list) + 1]; });
  std::partial_sum(lists.start.begin(), lists.start.end(), lists.start.begin());
  lists.items.resize(to_size(lists.start.back()));
  std::vector<int> next(lists.start.begin(), lists.start.end() - 1);
  each([&](int list, const Item& item) { lists.items[to_size(next[to_size(list)]++)] = item; });
  return lists;
}

}  // namespace bipot
