#pragma once

#include <filesystem>
#include <string>

namespace bipot {

/// The root of the source tree that these tests were built from.
std::filesystem::path source_folder();

/// The whole text of a file; empty where it cannot be read.
std::string file_text(const std::filesystem::path& path);

}  // namespace bipot
