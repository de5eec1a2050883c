#pragma once

#include <array>
#include <filesystem>
#include <vector>

namespace bipot {

/// A row of a file of positions: x, y, z (0 in the plane) and radius. [m]
using PositionRow = std::array<double, 4>;

/// Reads a CSV file with a head that names its columns: x, y, in 3D z, and radius, in any order.
/// Separated by commas, semicolons or tabs; case and spaces do not matter. Other columns are left
/// out, but z in the plane is refused. Throws SceneFileError with the line, FileError without a file.
std::vector<PositionRow> read_positions(const std::filesystem::path& path, int dim);

}  // namespace bipot
