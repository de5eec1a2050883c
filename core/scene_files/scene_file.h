#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <variant>

#include "core/scene/scene.h"

namespace bipot {

/// A scene file that cannot be used; the message names the file, the line and the key.
struct SceneFileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A scene in the plane or in space, as its file says.
using AnyScene = std::variant<Scene<2>, Scene<3>>;

/// Reads a TOML scene; data/manual/reference/scenes.md documents it key by key. Unknown keys are refused with
/// the nearest valid name, and so are scenes in space (dim = 3). Throws SceneFileError.
Scene<2> read_scene(const std::filesystem::path& path);

/// The same for scenes in space as well.
AnyScene read_any_scene(const std::filesystem::path& path);

/// The same from text; `source` names it in messages.
AnyScene parse_any_scene(const std::string& text, const std::string& source);
Scene<2> parse_scene(const std::string& text, const std::string& source);

}  // namespace bipot
