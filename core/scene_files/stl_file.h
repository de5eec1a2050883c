#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "core/base/types.h"

namespace bipot {

/// The triangles of an STL file, binary or text. Normals and attributes are not read; triangles
/// without area are left out. Throws SceneFileError for a damaged file, with the place.
std::vector<std::array<Vec3, 3>> read_stl(const std::filesystem::path& path);

}  // namespace bipot
