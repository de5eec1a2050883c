#pragma once

#include <optional>

#include "core/files/scene_table.h"
#include "core/scene/observable_choice.h"

namespace bipot {

/// The table [observables]; nothing where it is missing. Throws SceneFileError.
std::optional<ObservableChoice> read_observables(const SceneTable& root);

/// The same in space: of the whole sample, without profiles and lines.
std::optional<ObservableChoice> read_observables_in_space(const SceneTable& root);

}  // namespace bipot
