#pragma once

#include <string_view>

#include "core/files/scene_table.h"
#include "core/scene/scene.h"

namespace bipot {

/// Index of the material that the key names; of the first one where it is missing.
template <int D>
int material_index(const SceneIn<D>& scene, const SceneTable& table, std::string_view key);

/// One table of [[walls]], the one with this index. Throws SceneFileError.
template <int D>
WallIn<D> read_wall(const SceneTable& table, const SceneIn<D>& scene, std::size_t index);

}  // namespace bipot
