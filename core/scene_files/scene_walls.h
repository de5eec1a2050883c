#pragma once

#include <string_view>

#include "core/scene/scene.h"
#include "core/scene_files/scene_table.h"

namespace bipot {

/// Index of the material that the key names; without the key, of the first one.
template <int D>
int material_index(const Scene<D>& scene, const SceneTable& table, std::string_view key);

/// Reads one table of [[walls]], with this index. Throws SceneFileError.
template <int D>
Wall<D> read_wall(const SceneTable& table, const Scene<D>& scene, std::size_t index);

}  // namespace bipot
