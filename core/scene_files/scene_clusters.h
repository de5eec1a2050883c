#pragma once

#include "core/scene/scene.h"
#include "core/scene_files/scene_table.h"

namespace bipot {

/// Reads the tables [[clusters]] of a scene and appends their disks. Materials and other disks must
/// have been read. Throws SceneFileError.
void read_clusters(const SceneTable& root, Scene<2>& scene);

}  // namespace bipot
