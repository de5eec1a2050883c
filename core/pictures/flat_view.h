#pragma once

#include <vector>

#include "core/motion/state.h"
#include "core/scene/scene.h"

namespace bipot {

/// Spheres as disks in a plane, for the pictures of 2D scenes.
struct FlatView {
  Scene<2> scene;           ///< step, title and laws; walls seen edge-on, and cylinders
  State<2> state;           ///< disks; contacts between them with the normal forces in 3D
  std::vector<int> bodies;  ///< the sphere that each disk is
};

/// View along a horizontal line, with gravity downwards (without gravity: the third axis upwards).
/// It shows all spheres, the near ones drawn last, and all contacts. Branches are foreshortened,
/// normal forces are not. `front`: one number for each sphere; the larger ones are drawn later,
/// wherever they are.
FlatView project(const Scene<3>& scene, const State<3>& state,
                 const std::vector<double>& front = {});

/// The cut through the middle of the spheres, seen along the same line. Each sphere that is cut
/// appears as the disk of its section, with contacts between two of them or with a wall.
FlatView slice(const Scene<3>& scene, const State<3>& state);

}  // namespace bipot
