#pragma once

#include <filesystem>

namespace bipot {

/// Draws the frames of a run, as forces.png with disks coloured by speed, and joins them by the
/// program ffmpeg. `file`: .mp4 or .gif; empty: movie.mp4 in the folder of the run. Returns the
/// file. Throws Interrupted where an InterruptGuard asks for an end, FileError if ffmpeg is not
/// installed or fails, and std::invalid_argument for another ending.
std::filesystem::path write_run_movie(const std::filesystem::path& run, std::filesystem::path file,
                                      int frames_a_second = 30);

}  // namespace bipot
