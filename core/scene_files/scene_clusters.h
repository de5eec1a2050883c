#pragma once

#include "core/scene/scene.h"
#include "core/scene_files/scene_table.h"

namespace bipot {

/// The tables [[clusters]] of a scene, whose materials and disks are known: their disks come after these. Throws
/// SceneFileError.
void read_clusters(const SceneTable& root, Scene<2>& scene);

}  // namespace bipot
