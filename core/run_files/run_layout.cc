#include "core/run_files/run_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "core/base/number_text.h"
#include "core/files/input_file.h"

namespace bipot {

namespace fs = std::filesystem;

fs::path run_folder(const fs::path& run) {
  const bool named = fs::is_directory(run);
  if (!named && run.filename() != "run.h5") {
    throw FileError(run, "", "a run is named by its folder or by the run.h5 in it");
  }
  const fs::path folder = named ? run : run.has_parent_path() ? run.parent_path() : fs::path(".");
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) {
    if (entry.is_other()) require_regular_file(entry.path());  // a reader would wait
  }
  return folder;
}

std::string frame_name(int step) { return fmt::format("{:08d}", step); }

fs::path frame_path(const fs::path& folder, int step) {
  return folder / "frames" / (frame_name(step) + ".h5");
}

std::string bodies_group(const Hdf5File& file) {
  return file.exists("/disks") ? "/disks/" : "/bodies/";
}

std::vector<int> steps_in_folder(const fs::path& folder) {
  std::vector<int> steps;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder / "frames", error)) {
    if (entry.path().extension() != ".h5") continue;
    if (const auto step = whole_number<int>(entry.path().stem().string())) steps.push_back(*step);
  }
  std::sort(steps.begin(), steps.end());
  return steps;
}

}  // namespace bipot
