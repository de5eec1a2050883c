#include "core/linear/front_stack.h"

#include <algorithm>

namespace bipot {

template <class Real>
auto FrontStack<Real>::enter(int front) -> const std::vector<Child>& {
  const auto begin = held_.end() - tree_.children[to_size(front)];
  bottom_ = begin == held_.end() ? top_ : begin->second;
  std::size_t rows = 0;
  for (auto it = begin; it != held_.end(); ++it) rows += to_size(tree_.height(it->first));
  places_.resize(std::max(places_.size(), rows));
  children_.clear();
  int* place = places_.data();
  for (auto it = begin; it != held_.end(); ++it) {
    const int n = tree_.height(it->first);
    tree_.place_child(it->first, front, place);
    const auto pivots = std::lower_bound(place, place + n, tree_.columns(front)) - place;
    children_.push_back({memory_.data() + it->second, n, place, static_cast<int>(pivots)});
    place += n;
  }
  return children_;
}

template <class Real>
void FrontStack<Real>::leave(int front, std::size_t size) {
  held_.resize(held_.size() - children_.size());
  top_ = bottom_ + size;
  if (tree_.height(front) > 0) held_.emplace_back(front, bottom_);
}

template class FrontStack<float>;
template class FrontStack<double>;

}  // namespace bipot
