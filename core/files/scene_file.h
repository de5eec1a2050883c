#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

#include "core/scene/scene.h"

namespace bipot {

/// A scene file that cannot be used; the message names the file, the line and the key.
struct SceneFileError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Reads a TOML scene; data/scenes/README.md documents it key by key. Unknown keys are refused with
/// the nearest valid name. Throws SceneFileError.
Scene read_scene(const std::filesystem::path& path);

/// The same from text; `source` names it in messages.
Scene parse_scene(const std::string& text, const std::string& source);

}  // namespace bipot
