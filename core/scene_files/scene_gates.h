#pragma once

#include "core/scene/scene.h"
#include "core/scene_files/scene_table.h"

namespace bipot {

/// Reads the tables [[outlets]] and [[inlets]] of a scene, whose materials must have been read.
/// `turned`: the scene as a whole is turned, which excludes boxes along the axes. Throws
/// SceneFileError.
template <int D>
void read_gates(const SceneTable& root, bool turned, Scene<D>& scene);

}  // namespace bipot
