#pragma once

#include <filesystem>
#include <vector>

#include "core/base/types.h"

namespace bipot {

/// A row of a file of bodies; in the plane spin is the third component, all other third ones are 0.
struct PositionRow {
  Vec3 x = Vec3::Zero();     ///< [m]
  Vec3 v = Vec3::Zero();     ///< [m/s]
  Vec3 spin = Vec3::Zero();  ///< [rad/s]
  double radius = 0;         ///< > 0 [m]
  bool driven = false;       ///< v and spin are prescribed
};

/// Reads a CSV file with a head that names its columns: x, y, in 3D z, and radius, in any order.
/// vx, vy, vz and spin (in 3D spin_x, spin_y, spin_z) may follow; they are 0 without a column.
/// Separated by commas, semicolons or tabs; case and spaces do not matter. Other columns are left
/// out, but names near to one of these, and those of the other dimension, are refused. Throws
/// SceneFileError with the line, FileError without a file.
std::vector<PositionRow> read_positions(const std::filesystem::path& path, int dim);

}  // namespace bipot
