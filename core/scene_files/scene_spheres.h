#pragma once

#include <vector>

#include "core/scene/scene.h"
#include "core/scene_files/scene_table.h"

namespace bipot {

/// One table of [[spheres]]: a sphere or an arrangement. Throws SceneFileError.
std::vector<Sphere> read_spheres(const SceneTable& table, const Scene<3>& scene);

}  // namespace bipot
