#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace bipot {

inline constexpr std::size_t kMostPageBytes = 20'000'000;

struct RunPage {
  std::filesystem::path path;
  std::size_t bytes = 0, frames = 0;
};

/// Writes index.html into the folder of a run, finished or interrupted: a page of one file that plays
/// the run, with nothing to load. Frames are those of its film (core/run_files/film.h). A run without
/// one, of an older version, has the frames of its HDF5 files. A page has at most 20 MB: frames go
/// first, then weak contacts, and the page says so. Throws FileError.
RunPage write_run_page(const std::filesystem::path& run, std::size_t most_bytes = kMostPageBytes);

/// The same page as text, for a run that goes on: it asks its server for what is new
/// (page_update). Throws FileError.
std::string live_run_page(const std::filesystem::path& run);

/// What an open page of a run lacks (player/live.js reads it): the frames of the film after step
/// `after`, and the curves and marks of the whole run, as JSON. `ended`: the run is over, and the
/// summary comes as well. Throws FileError.
std::string page_update(const std::filesystem::path& folder, int after, bool ended);

}  // namespace bipot
