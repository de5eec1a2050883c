#pragma once

#include "core/base/types.h"

namespace bipot {

/// Box along the axes; empty (lower > upper) until something is included. [m]
template <int D>
struct Box {
  Vec<D> lower = Vec<D>::Constant(1e300), upper = Vec<D>::Constant(-1e300);

  bool empty() const { return !(lower.array() <= upper.array()).all(); }
  void include(const Vec<D>& x) {
    lower = lower.cwiseMin(x);
    upper = upper.cwiseMax(x);
  }
  /// A round body.
  void include(const Vec<D>& x, double radius) {
    include(x - Vec<D>::Constant(radius));
    include(x + Vec<D>::Constant(radius));
  }
  void widen(double by) {
    lower.array() -= by;
    upper.array() += by;
  }
  /// Lower edges belong to it, upper ones do not.
  bool contains(const Vec<D>& x) const {
    return (x.array() >= lower.array()).all() && (x.array() < upper.array()).all();
  }
  /// The point of it that is nearest to x.
  Vec<D> nearest(const Vec<D>& x) const { return x.cwiseMax(lower).cwiseMin(upper); }
  /// Along the first two axes.
  Box<2> flat() const { return {lower.template head<2>(), upper.template head<2>()}; }
  Vec<D> size() const { return upper - lower; }
  Vec<D> centre() const { return 0.5 * (lower + upper); }
};

}  // namespace bipot
