#pragma once

#include <optional>

#include "core/scene/cell.h"
#include "core/scene/observable_choice.h"
#include "core/scene_files/scene_table.h"

namespace bipot {

/// The table [observables]; empty without it. Throws SceneFileError.
std::optional<ObservableChoice<2>> read_observables(const SceneTable& root);

/// The same in 3D. Windows, profiles and faces lie in the cell.
std::optional<ObservableChoice<3>> read_observables_in_space(const SceneTable& root,
                                                             const PeriodicCell& cell);

}  // namespace bipot
