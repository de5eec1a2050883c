#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "core/linear/frontal_tree.h"

namespace bipot {

/// Contributions of fronts to their parents while a tree is eliminated, children before parents.
/// They form a stack: those of the next front's children are on top. A front makes its own above
/// them, and moves it to the start of theirs. Real: float or double.
template <class Real>
class FrontStack {
 public:
  /// Keeps references to both. `memory` must hold the stack and the contribution being made.
  FrontStack(const FrontalTree& tree, std::vector<Real>& memory) : tree_(tree), memory_(memory) {}

  /// Contribution of a child, in the storage of its factorisation.
  struct Child {
    const Real* block;
    int rows;
    const int* place;  ///< of each row among the rows of the parent, ascending
    int pivots;        ///< number of rows that the parent eliminates
  };
  /// The children of a front, valid until leave().
  const std::vector<Child>& enter(int front);
  /// Memory for the front's contribution, before its move and after it.
  Real* own() { return memory_.data() + top_; }
  Real* bottom() { return memory_.data() + bottom_; }
  /// Drops the children; the contribution of the front has `size` numbers.
  void leave(int front, std::size_t size);

 private:
  const FrontalTree& tree_;
  std::vector<Real>& memory_;
  std::vector<std::pair<int, std::size_t>> held_;  // fronts with a contribution, its start
  std::size_t top_ = 0, bottom_ = 0;
  std::vector<Child> children_;
  std::vector<int> places_;  // of all children
};

}  // namespace bipot
