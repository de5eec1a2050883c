#pragma once

#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>

#include "core/scene/scene.h"

namespace bipot {

/// Error in a scene file; the message names the file, the line and the key.
struct SceneFileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A scene in 2D or 3D, as its file says.
using AnyScene = std::variant<Scene<2>, Scene<3>>;

/// Reads a TOML scene in 2D; data/manual/reference/scenes.md describes every key. Unknown keys are
/// refused with the nearest valid name. Scenes in 3D (dim = 3) are refused. Throws SceneFileError,
/// and FileError if there is no such file.
Scene<2> read_scene(const std::filesystem::path& path);

/// Reads a scene in 2D or 3D.
AnyScene read_any_scene(const std::filesystem::path& path);

/// The same from text; `source` names it in messages. `accuracy`: instead of the scene's.
AnyScene parse_any_scene(const std::string& text, const std::string& source,
                         std::optional<double> accuracy = {});
Scene<2> parse_scene(const std::string& text, const std::string& source);

/// The contact distance of a scene whose file gives none. Touching lattices have gaps of the size of
/// rounding: it covers them and is negligible otherwise, also beside the accuracy.            [m]
template <int D>
double default_contact_distance(const Scene<D>& scene);

}  // namespace bipot
