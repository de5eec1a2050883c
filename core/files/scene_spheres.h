#pragma once

#include <vector>

#include "core/files/scene_table.h"
#include "core/scene/scene.h"

namespace bipot {

/// One table of [[spheres]]: a sphere or an arrangement. Throws SceneFileError.
std::vector<Sphere> read_spheres(const SceneTable& table, const SceneIn<3>& scene);

}  // namespace bipot
