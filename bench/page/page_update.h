#pragma once

#include <filesystem>
#include <string>

namespace bipot {

/// What an open page of a run lacks (player/live.js reads it): the frames of the film after step
/// `after`, and the curves and marks of the whole run, as JSON. `ended`: the run is over, and the
/// summary comes as well. Throws FileError.
std::string page_update(const std::filesystem::path& folder, int after, bool ended);

}  // namespace bipot
