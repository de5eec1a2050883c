#pragma once

#include "core/files/scene_table.h"
#include "core/scene/scene.h"

namespace bipot {

/// The tables [[clusters]] of a scene, whose materials and disks are known: their disks come after these. Throws
/// SceneFileError.
void read_clusters(const SceneTable& root, Scene& scene);

}  // namespace bipot
