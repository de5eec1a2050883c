#pragma once

#include "core/files/scene_table.h"
#include "core/scene/cell.h"

namespace bipot {

/// The table [cell]; no cell where it is missing. Throws SceneFileError.
PeriodicCell read_cell(const SceneTable& root);

}  // namespace bipot
