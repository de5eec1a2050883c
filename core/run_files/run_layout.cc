#include "core/run_files/run_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <system_error>

#include "core/base/number_text.h"
#include "core/files/input_file.h"

namespace bipot {

namespace fs = std::filesystem;

fs::path run_folder(const fs::path& run) {
  const bool named = fs::is_directory(run);
  if (!named && run.filename() != "run.h5") {
    if (!fs::exists(run)) throw FileError(run, "", "no such folder or file");
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

void remove_run(const fs::path& folder) {
  const auto remove = [](const fs::path& file) {
    std::error_code error;
    fs::remove(file, error);
    if (error) throw FileError(file, "", "cannot remove: " + error.message());
  };
  const auto files_in = [](const fs::path& place) {
    std::vector<fs::path> files;
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(place, none)) files.push_back(entry.path());
    return files;
  };
  constexpr std::array kFiles = {
      "run.h5",       "run.xdmf",        "film.bin",   "index.html",       "ledger.csv",
      "gates.csv",    "walls.csv",       "units.csv",  "trajectory.csv",   "profile.csv",
      "forces.csv",   "forces_mean.csv", "forces.svg", "profile_mean.csv", "forces.png",
      "summary.json", "run.log",         "slice.svg",  "stress.svg",       "start.png",
      "slice.png",    "stress.png"};
  for (const fs::path& file : files_in(folder)) {
    const std::string name = file.filename().string();
    const bool chart = name.starts_with("observables");  // or its table
    if (chart || std::find(kFiles.begin(), kFiles.end(), name) != kFiles.end()) remove(file);
  }
  for (const int step : steps_in_folder(folder)) remove(frame_path(folder, step));
  for (const fs::path& file : files_in(folder / "problems")) {
    if (file.filename().string().starts_with("step_")) remove(file);
  }
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
