#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/scene/scene.h"
#include "core/scene/scene_box.h"

namespace bipot {

/// A cylinder is drawn as a prism with this number of sides.
inline constexpr int kPrismSides = 48;

/// A plane piece of a wall in 3D, as it is drawn.
struct WallPiece {
  int wall = 0;
  std::array<Vec3, 4> corners;  ///< in order around it; all one point: nothing to see      [m]
};

/// One piece for each half-space: the plane within the box. kPrismSides pieces for each cylinder,
/// as long as the box, and for each cone. A triangle has its last corner twice. Absent walls keep
/// theirs, as points.
std::vector<WallPiece> wall_pieces(std::span<const Wall<3>> walls, const Box<3>& box);

/// Number of pieces of these walls.
std::size_t num_wall_pieces(std::span<const Wall<3>> walls);

/// Region that a drawing of spheres should show: the spheres, or if there are none the walls'
/// points.
Box<3> view_box(std::span<const Sphere> spheres, std::span<const Wall<3>> walls);

}  // namespace bipot
