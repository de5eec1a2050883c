#pragma once

#include <utility>
#include <vector>

#include "core/base/types.h"
#include "core/motion/state.h"

namespace bipot {

/// The same state with each disk, and the centre of mass of each cluster, in the cell (0, 0), at
/// the velocity of the image there. It serves pictures, windows and profiles. Images of contacts
/// are those between the bodies in their new places. Other states are returned unchanged.
template <int D>
State<D> wrapped_state(const State<D>& state);

/// The line of a contact in a drawing: from the centre of disk i to that of j, to that of the image
/// of j in contact, or to the point of contact with a wall. [m]
template <int D>
std::pair<Vec<D>, Vec<D>> drawn_branch(const State<D>& state, const Contact<D>& contact);

/// The edges of the rectangle that contains the disks after wrapped_state(): [0, width) x [0,
/// height). For a cell periodic in x alone, two lines as high as the box.
std::vector<std::pair<Vec2, Vec2>> cell_outline(const PeriodicCell& cell, const Box<2>& box);
/// In 3D: the twelve edges of the block over the cell, as high as the box. For a cell periodic in x
/// alone, two rectangles as wide and high as the box.
std::vector<std::pair<Vec3, Vec3>> cell_outline(const PeriodicCell& cell, const Box<3>& box);

/// Shifts of the images of the cell that may reach into it; only zero if the scene is not periodic.
/// [m]
std::vector<Vec2> image_shifts(const PeriodicCell& cell);

/// Images with which contents of that extent may reach into the box, the sample itself first. The
/// box may be longer than the cell. [m]
std::vector<CellNumber> images_over(const PeriodicCell& cell, const Box<2>& contents,
                                    const Box<2>& box);
/// The extent of the bodies, in the plane of the cell. [m]
template <int D>
Box<2> extent_of_bodies(const State<D>& state) {
  Box<2> box;
  for (const Body<D>& d : state.bodies) box.include(d.x.template head<2>(), d.radius);
  return box;
}

}  // namespace bipot
