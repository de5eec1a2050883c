#pragma once

#include <vector>

#include "core/scene/scene.h"
#include "core/scene/scene_box.h"

namespace bipot {

/// The room that walls enclose: before half-planes, inside hollow circles, outside solid ones, and
/// inside closed lines of segments.
template <int D>
struct WallRoom {
  std::vector<Wall<D>> walls;
  /// Bounds of the room by circles, segments and half-planes along the axes; else infinite. [m]
  Box<D> box{Vec<D>::Constant(-kInfinity), Vec<D>::Constant(kInfinity)};

  /// True if a body with this centre and radius lies in the room, touching allowed. [m]
  bool holds(const Vec<D>& x, double radius) const;
};

/// Throws std::invalid_argument for no walls, and for segments without a closed line.
template <int D>
WallRoom<D> room_within(std::vector<Wall<D>> walls);

}  // namespace bipot
