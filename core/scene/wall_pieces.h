#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/scene/scene.h"
#include "core/scene/scene_box.h"

namespace bipot {

/// A cylinder is drawn as a prism with so many sides.
inline constexpr int kPrismSides = 48;

/// A plane piece of a wall in space, as it is drawn.
struct WallPiece {
  int wall = 0;
  std::array<Vec3, 4> corners;  ///< in order around it; all one point: nothing to see      [m]
};

/// Of each half-space one piece, the plane as far as the box reaches; of each cylinder kPrismSides,
/// as long as the box. Walls that are not present keep theirs, as points.
std::vector<WallPiece> wall_pieces(std::span<const Wall<3>> walls, const Box<3>& box);

/// How many of them these walls have.
std::size_t num_wall_pieces(std::span<const Wall<3>> walls);

/// What a drawing of spheres should show: the spheres, or without any the walls' points.
Box<3> view_box(std::span<const Sphere> spheres, std::span<const Wall<3>> walls);

}  // namespace bipot
