#pragma once

#include "core/scene/cell.h"
#include "core/scene_files/scene_table.h"

namespace bipot {

/// The table [cell]; no cell where it is missing. Throws SceneFileError.
PeriodicCell read_cell(const SceneTable& root);

/// The same in space: width along x, depth along y, which stay as they are.
PeriodicCell read_cell_in_space(const SceneTable& root);

}  // namespace bipot
