#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace bipot {

/// The folder of shipped data: $BIPOT_DATA, else share/bipot of an installed command or Python
/// module, else data/ of the source tree of the build.
std::filesystem::path data_folder();

/// Scene files in data/scenes, sorted by name.
std::vector<std::filesystem::path> shipped_scenes();

/// Commented scenes to begin with, in data/templates, sorted by name.
std::vector<std::filesystem::path> scene_templates();

/// The names of such files, as a user gives them.
std::vector<std::string> names_of(const std::vector<std::filesystem::path>& files);

/// Files in data/problems, sorted by name.
std::vector<std::filesystem::path> shipped_problems();

/// The shipped problem of that name, unless such a file exists; else the path itself.
std::filesystem::path find_problem(const std::string& path_or_name);

/// The path itself if such a file exists, else the shipped scene of that name, also beside a folder
/// of that name. Throws std::invalid_argument, naming the nearest shipped scene.
std::filesystem::path find_scene(const std::string& path_or_name);

/// A scene, and the steps that stand behind it: "my.toml:steps=250".
struct SceneOfLength {
  std::filesystem::path path;
  std::optional<int> steps;
};

/// Throws as find_scene, and for other words behind the scene.
SceneOfLength find_scene_of_length(const std::string& target);

}  // namespace bipot
