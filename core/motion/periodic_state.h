#pragma once

#include <utility>
#include <vector>

#include "core/motion/state.h"
#include "core/scene/scene_box.h"

namespace bipot {

/// The same state with each disk, and the centre of mass of each cluster, in the cell (0, 0), for what looks at places: pictures, windows,
/// profiles, and with the velocity that the image there has. Images of contacts are those between the bodies in their new places. A state that is
/// not periodic comes back as it is.
template <int D>
State<D> wrapped_state(const State<D>& state);

/// The line of a contact in a drawing: from the centre of disk i to that of j, or of the image of j
/// that it touches, or to the point where it touches a wall.                               [m]
template <int D>
std::pair<Vec<D>, Vec<D>> drawn_branch(const State<D>& state, const Contact<D>& contact);

/// The edges of the rectangle in which wrapped_state() leaves the disks, [0, width) x [0, height); of one that is periodic in x alone, two lines as high as the box.
std::vector<std::pair<Vec2, Vec2>> cell_outline(const PeriodicCell& cell, const Box<2>& box);
/// In space: the twelve edges of the block over the cell, as high as the box; of one that is periodic in x alone, two rectangles
/// as wide and high as the box.
std::vector<std::pair<Vec3, Vec3>> cell_outline(const PeriodicCell& cell, const Box<3>& box);

/// The shifts of the images of the cell that may reach into it: none but zero in a scene that is
/// not periodic.                                                                            [m]
std::vector<Vec2> image_shifts(const PeriodicCell& cell);

}  // namespace bipot
