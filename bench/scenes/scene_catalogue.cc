#include "bench/scenes/scene_catalogue.h"

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

#include "core/nearest_name.h"

namespace bipot {

std::filesystem::path data_folder() {
  if (const char* folder = std::getenv("BIPOT_DATA")) return folder;
  // An installed command stands in bin/, its data in share/bipot beside it.
  std::error_code none;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", none);
  const std::filesystem::path installed = program.parent_path().parent_path() / "share/bipot";
  if (std::filesystem::is_directory(installed, none)) return installed;
  return std::filesystem::path(BIPOT_SOURCE_DIR) / "data";
}

std::vector<std::filesystem::path> shipped_scenes() {
  std::vector<std::filesystem::path> scenes;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(data_folder() / "scenes", none)) {
    if (entry.path().extension() == ".toml") scenes.push_back(entry.path());
  }
  std::sort(scenes.begin(), scenes.end());
  return scenes;
}

std::filesystem::path find_scene(const std::string& path_or_name) {
  if (std::filesystem::is_regular_file(path_or_name)) return path_or_name;
  std::vector<std::string> names;
  for (const std::filesystem::path& scene : shipped_scenes()) {
    names.push_back(scene.stem().string());
    if (names.back() == path_or_name) return scene;
  }
  throw std::invalid_argument(path_or_name + ": no such file; " +
                              unknown_name_message("shipped scene", path_or_name, names));
}

}  // namespace bipot
