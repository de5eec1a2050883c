#include "bench/problems/scene_catalogue.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

#include "core/base/file_error.h"
#include "core/base/nearest_name.h"
#include "core/base/number_text.h"
#include "core/files/input_file.h"

namespace bipot {
namespace {

/// The folder above bin/ of an installed command. Likewise for an installed module, which is a
/// shared object in lib/python3.11/dist-packages/bipot.
std::filesystem::path install_prefix() {
  std::error_code none;
  Dl_info self{};
  if (dladdr(reinterpret_cast<const void*>(&data_folder), &self) != 0) {
    const std::filesystem::path object = std::filesystem::absolute(self.dli_fname, none);
    if (object.extension() == ".so") {
      return (object.parent_path() / "../../../..").lexically_normal();
    }
  }
  return std::filesystem::read_symlink("/proc/self/exe", none).parent_path().parent_path();
}

/// Files of a folder of shipped data with this ending, sorted by name.
std::vector<std::filesystem::path> shipped_files(const char* folder, const char* ending) {
  std::vector<std::filesystem::path> files;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(data_folder() / folder, none)) {
    if (entry.path().extension() == ending) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

std::filesystem::path data_folder() {
  if (const char* folder = std::getenv("BIPOT_DATA"); folder != nullptr && *folder != '\0') {
    return folder;
  }
  std::error_code none;
  std::filesystem::path installed = install_prefix() / "share/bipot";
  if (std::filesystem::is_directory(installed, none)) return installed;
  return std::filesystem::path(BIPOT_SOURCE_DIR) / "data";
}

std::vector<std::filesystem::path> shipped_scenes() { return shipped_files("scenes", ".toml"); }
std::vector<std::filesystem::path> scene_templates() { return shipped_files("templates", ".toml"); }
std::vector<std::filesystem::path> shipped_problems() { return shipped_files("problems", ".hdf5"); }

std::vector<std::string> names_of(const std::vector<std::filesystem::path>& files) {
  std::vector<std::string> names;
  for (const auto& file : files) names.push_back(file.stem().string());
  return names;
}

std::filesystem::path find_problem(const std::string& path_or_name) {
  if (std::filesystem::exists(path_or_name)) return path_or_name;
  for (const std::filesystem::path& problem : shipped_problems()) {
    if (problem.stem() == path_or_name) return problem;
  }
  return path_or_name;
}

std::filesystem::path find_scene(const std::string& path_or_name) {
  const bool there = std::filesystem::exists(path_or_name);
  const bool file = there && !std::filesystem::is_directory(path_or_name);
  for (const std::filesystem::path& scene : shipped_scenes()) {
    // Results of a scene often stand in a folder of its name, which is no scene.
    if (scene.stem() == path_or_name && !file) return scene;
  }
  if (!there) {
    const std::vector<std::string> templates = names_of(scene_templates());
    const std::string file_name = path_or_name + ".toml";
    const bool is_template =
        std::find(templates.begin(), templates.end(), path_or_name) != templates.end();
    throw std::invalid_argument(
        path_or_name + ": no such file; " +
        (std::filesystem::exists(file_name) ? "did you mean '" + file_name + "'?"
         : is_template ? "a template: bipot new " + path_or_name + " > " + file_name
         : shipped_scenes().empty()
             ? data_folder().string() + " has no shipped scenes either (BIPOT_DATA)"
             : unknown_name_message("shipped scene", path_or_name, names_of(shipped_scenes()))));
  }
  try {
    require_regular_file(path_or_name);
  } catch (const FileError& e) {
    throw std::invalid_argument(e.what());
  }
  return path_or_name;
}

SceneOfLength find_scene_of_length(const std::string& target) {
  std::string file = target;
  std::optional<int> steps;
  for (std::size_t at = 0;
       !std::filesystem::exists(file) && (at = file.rfind(':')) != std::string::npos;
       file.resize(at)) {
    const std::string part = file.substr(at + 1), key = part.substr(0, part.find('='));
    if (key != "steps") {
      throw std::invalid_argument(target + ": " + unknown_name_message("part", key, {"steps"}));
    }
    steps = whole_number<int>(part.substr(std::min(key.size() + 1, part.size())));
    if (!(steps >= 1)) {
      throw std::invalid_argument(target + ": expected a positive number of steps");
    }
  }
  return {find_scene(file), steps};
}

}  // namespace bipot
