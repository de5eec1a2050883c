#pragma once

#include <filesystem>

namespace bipot {

struct MovieOptions {
  std::filesystem::path file;  ///< .mp4 or .gif; empty: movie.mp4 in the folder of the run
  int frames_a_second = 30;
};

/// Draws the frames of a run, as forces.png with disks coloured by speed, and joins them by the
/// program ffmpeg. Returns the file. Throws FileError if ffmpeg is not installed or fails, and
/// std::invalid_argument for another ending.
std::filesystem::path write_run_movie(const std::filesystem::path& run,
                                      const MovieOptions& options = {});

}  // namespace bipot
