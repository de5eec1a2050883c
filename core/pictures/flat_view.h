#pragma once

#include <vector>

#include "core/motion/state.h"
#include "core/scene/scene.h"

namespace bipot {

/// Spheres as disks in a plane, so that the pictures of the plane show them.
struct FlatView {
  Scene<2> scene;           ///< step, title and laws; walls that are seen edge-on, and cylinders
  State<2> state;           ///< disks; contacts between them with the normal forces of space
  std::vector<int> bodies;  ///< the sphere that each disk is
};

/// What one sees along a horizontal line, gravity downwards (without gravity: the third axis
/// upwards): all spheres, the near ones drawn last, and all contacts. Branches are foreshortened,
/// the normal forces are not.
FlatView project(const Scene<3>& scene, const State<3>& state);

/// The cut through the middle of the spheres, seen along the same line: each sphere that is cut, as
/// the disk that it leaves there, and the contacts between two of them or with a wall.
FlatView slice(const Scene<3>& scene, const State<3>& state);

}  // namespace bipot
