#pragma once

#include "core/scene/cell.h"
#include "core/scene_files/scene_table.h"

namespace bipot {

/// The table [cell]; without it no cell. Throws SceneFileError.
PeriodicCell read_cell(const SceneTable& root);

/// The same in 3D: width along x, depth along y, both fixed.
PeriodicCell read_cell_in_space(const SceneTable& root);

}  // namespace bipot
