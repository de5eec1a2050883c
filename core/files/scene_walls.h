#pragma once

#include <string_view>

#include "core/files/scene_table.h"
#include "core/scene/scene.h"

namespace bipot {

/// Index of the material that the key names; of the first one where it is missing.
int material_index(const Scene& scene, const SceneTable& table, std::string_view key);

/// One table of [[walls]], the one with this index. Throws SceneFileError.
Wall read_wall(const SceneTable& table, const Scene& scene, std::size_t index);

}  // namespace bipot
