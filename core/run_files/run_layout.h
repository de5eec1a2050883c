#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/file_error.h"
#include "core/files/hdf5_file.h"

namespace bipot {

/// Names in the folder of a run; data/manual/reference/files.md describes the files.
inline constexpr const char* kRunFormat = "bipot run";  ///< /format of run.h5
/// /format_version of run.h5. Version 1 has /disks instead of /bodies.
inline constexpr int kRunFormatVersion = 2;

/// The folder of a run, which is named by the folder itself or by its run.h5. Throws FileError for
/// anything else, a missing folder included.
std::filesystem::path run_folder(const std::filesystem::path& run);

/// Name of the frame after `step`: its link in run.h5, its file without the extension.
std::string frame_name(int step);
std::filesystem::path frame_path(const std::filesystem::path& folder, int step);

/// The group of the bodies in run.h5 or a frame: "/bodies/", in files of version 1 "/disks/".
std::string bodies_group(const Hdf5File& file);

/// Removes the files of a run from its folder; others stay. Throws FileError.
void remove_run(const std::filesystem::path& folder);

/// Steps of the frames in the folder of a run, increasing; empty if there is no such folder.
std::vector<int> steps_in_folder(const std::filesystem::path& folder);

}  // namespace bipot
