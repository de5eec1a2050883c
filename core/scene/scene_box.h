#pragma once

#include <span>
#include <utility>
#include <vector>

#include "core/scene/scene.h"

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
  Vec<D> size() const { return upper - lower; }
  Vec<D> centre() const { return 0.5 * (lower + upper); }
};

/// Region that a picture of disks and walls should show: the disks, the nearby parts of walls, and
/// walls about as near as the disks are wide. Never empty.
Box<2> view_box(std::span<const Disk> disks, std::span<const Wall<2>> walls);

/// The two ends of each wall as it is drawn. A segment has its own ends. The line of a half-plane
/// extends as far as the box in its direction, except where another half-plane covers it. Circles
/// and absent walls have no line: both ends are one point.
std::vector<std::pair<Vec2, Vec2>> wall_lines(std::span<const Wall<2>> walls, const Box<2>& box);

}  // namespace bipot
